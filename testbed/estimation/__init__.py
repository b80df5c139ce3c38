"""Inertia estimators, each with its covariance, and the Cramér-Rao bound of the motion."""
