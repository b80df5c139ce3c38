"""The sections of a run's page, one module each; a section takes only what it shows."""
