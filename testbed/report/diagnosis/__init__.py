"""The page of a diagnosis: one module for each of its sections."""
