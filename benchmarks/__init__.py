"""Measured figures: what docs/benchmarks.md and docs/blind.md say, by commands that anyone can repeat."""

import os
from pathlib import Path

from testbed.effects.library import FOLDER_VARIABLE

# What is measured does not know the effects of whoever measures.
os.environ[FOLDER_VARIABLE] = str(Path(__file__).with_name("no_effects"))
