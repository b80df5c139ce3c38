"""A simulator-in-the-loop testbed for identifying a spacecraft's inertia with control moment gyros."""
