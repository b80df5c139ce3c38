"""The table of all cases."""

from __future__ import annotations

from itertools import chain

from tests.robustness import campaigns, command_line, logs, models, records, scenario_files, scenario_values, scenes

_MODULES = (scenario_values, scenario_files, models, records, logs, command_line, campaigns, scenes)
CASES = tuple(chain.from_iterable(module.cases() for module in _MODULES))
