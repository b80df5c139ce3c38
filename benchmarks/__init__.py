"""Measured figures: what docs/benchmarks.md and docs/blind.md say, by commands that anyone can repeat."""

import os

from testbed.effects.library import FOLDER_VARIABLE

os.environ[FOLDER_VARIABLE] = os.devnull  # what is measured does not know the effects of whoever measures
