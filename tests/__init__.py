import os

from testbed.effects.library import FOLDER_VARIABLE

os.environ[FOLDER_VARIABLE] = os.devnull  # tests do not know the effects of whoever runs them
