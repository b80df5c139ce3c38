"""Torque laws as formulas: a parsed grammar, evaluated alike in the simulation and in the prediction."""
