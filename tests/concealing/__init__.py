"""Blind data sets: a gyrostat with six gimbals, its own equations of motion, effects and sensors, and sealed answers.

Nothing here is used by the diagnosis, and the physics, effects and sensors here use nothing of the testbed: what both
sides got wrong alike would go unseen. Only `guidance` imports the testbed, for the controller as flown.
"""
