"""Maneuvers and their design for the most information. The only room with CasADi."""
