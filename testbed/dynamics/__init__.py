"""Rigid-body dynamics in the paper's form: the inertia parameters, their regressors, and Euler's equation."""
