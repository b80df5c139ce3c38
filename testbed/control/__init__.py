"""The rate tracker and the gimbal servo."""
