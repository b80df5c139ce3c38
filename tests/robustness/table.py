"""The table of all cases."""

from __future__ import annotations

from itertools import chain

from tests.robustness import records, scenario_values

CASES = tuple(chain(scenario_values.cases(), records.cases()))
