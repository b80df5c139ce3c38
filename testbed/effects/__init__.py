"""The named effects that a model may be missing: one file each, one shared contract."""
