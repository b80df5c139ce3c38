"""Prediction of measured runs from their own telemetry: many runs and parameter sets at once, exact derivatives."""
