import os
from pathlib import Path

from testbed.effects.library import FOLDER_VARIABLE

# Tests do not know the effects of whoever runs them.
os.environ[FOLDER_VARIABLE] = str(Path(__file__).with_name("no_effects"))
