"""A run's time series: read, validated, written."""
