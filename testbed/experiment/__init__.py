"""One experiment from scenario to estimates: plan the maneuver, fly it, estimate, and put the figures together."""
