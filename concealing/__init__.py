"""Blind data sets: a gyrostat with gimbals or wheels, its own equations of motion, effects and sensors; sealed answers.

Nothing here is used by the diagnosis, and the equations of motion, effects and sensors here use nothing of the testbed:
what both sides got wrong alike would go unseen. So would a mistake in what is shared: controller, splines, cluster and
scenario reader (`guidance`), the records' writer (`files`, `sealing`), the nominal MJCF (`mujoco_craft`). Craft with
reaction wheels share the writer alone.
"""
