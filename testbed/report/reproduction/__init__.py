"""The page of a reproduction: the paper's tables and figures beside this testbed's."""
