"""How many there may be, for the command line, for Python and for scenarios alike."""

LARGEST_SEED = 2**63 - 1
"""Fits a signed 64-bit column; files and libraries know no larger integers."""
MOST_RUNS = 1_000_000
"""Of a campaign: its table of results takes 1 GB, and a flight of 0.06 s half a day of one core."""
MOST_WORKERS = 1024
"""Processes on one machine: more than any has cores."""
