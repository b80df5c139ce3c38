"""Gyro, gimbal encoders and tachometers, with seeded noise."""
