"""The closed loop, its clock and its outcome."""
