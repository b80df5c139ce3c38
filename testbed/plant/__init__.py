"""The simulated platform. The only room with MuJoCo."""

import mujoco

# Its warnings would go to the terminal, and into MUJOCO_LOG.TXT in the current folder. A state that diverges is found
# by looking at it, and what cannot be compiled raises an error.
_log = mujoco.MjLogConfig.get()
_log.logto_console = _log.logto_file = False
_log.set()
