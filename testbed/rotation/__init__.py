"""Quaternions and attitude kinematics; quat_NB is scalar-first and takes B components to N."""
