"""Prediction of measured runs from their own telemetry: many runs and parameter sets together, exact derivatives."""
