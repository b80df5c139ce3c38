"""Diagnoses of blind data sets against their sealed answers: the score card of docs/scoring.md."""
