"""The paper's tables and figures, made again from this testbed, beside the paper's own numbers."""
