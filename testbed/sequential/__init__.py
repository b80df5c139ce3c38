"""Flying until a verdict is sure: e-values by flight, what is wanted, the flight that is expected to show most."""
