"""The table of all cases."""

from __future__ import annotations

from itertools import chain

from tests.robustness import scenario_values

CASES = tuple(chain(scenario_values.cases()))
