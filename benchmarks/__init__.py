"""Measured figures: what docs/benchmarks.md and docs/blind.md say, by commands that anyone can repeat."""
