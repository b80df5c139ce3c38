"""Identify a spacecraft's inertia in a closed loop with a simulator, and find what a model is missing.

    import testbed as tb

    scenario = tb.read_scenario("zero_g")
    run = tb.fly(scenario, seed=1)

What is here loads when it is used first: `import testbed` itself loads no engine.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from testbed import effects as effects
    from testbed.effects.contract import Effect as Effect
    from testbed.effects.contract import Extension as Extension
    from testbed.effects.contract import Parameter as Parameter
    from testbed.effects.registry import register_effect as register_effect
    from testbed.errors import InputError as InputError
    from testbed.library.adoption import Adoption as Adoption
    from testbed.library.adoption import adopt as adopt
    from testbed.library.campaigns import Campaign as Campaign
    from testbed.library.campaigns import monte_carlo as monte_carlo
    from testbed.library.comparisons import Comparison as Comparison
    from testbed.library.comparisons import compare as compare
    from testbed.library.diagnoses import DiagnosisResult as DiagnosisResult
    from testbed.library.diagnoses import diagnose as diagnose
    from testbed.library.estimates import InertiaEstimate as InertiaEstimate
    from testbed.library.estimates import estimate as estimate
    from testbed.library.exporting import export as export
    from testbed.library.imports import ImportedRecords as ImportedRecords
    from testbed.library.imports import guess_map as guess_map
    from testbed.library.imports import import_log as import_log
    from testbed.library.plans import FlightPlan as FlightPlan
    from testbed.library.plans import plan as plan
    from testbed.library.records import Records as Records
    from testbed.library.records import frame_of as frame_of
    from testbed.library.records import read_records as read_records
    from testbed.library.records import records_from as records_from
    from testbed.library.runs import Maneuver as Maneuver
    from testbed.library.runs import Run as Run
    from testbed.library.runs import design as design
    from testbed.library.runs import fly as fly
    from testbed.library.scenarios import read_scenario as read_scenario
    from testbed.prediction.hooks import Hooks as Hooks
    from testbed.prediction.hooks import Instant as Instant
    from testbed.scenario.shipped import shipped_scenarios as shipped_scenarios

_HOMES = {
    "Effect": "testbed.effects.contract",
    "Extension": "testbed.effects.contract",
    "Parameter": "testbed.effects.contract",
    "register_effect": "testbed.effects.registry",
    "Hooks": "testbed.prediction.hooks",
    "Instant": "testbed.prediction.hooks",
    "InputError": "testbed.errors",
    "Adoption": "testbed.library.adoption",
    "adopt": "testbed.library.adoption",
    "Campaign": "testbed.library.campaigns",
    "monte_carlo": "testbed.library.campaigns",
    "Comparison": "testbed.library.comparisons",
    "compare": "testbed.library.comparisons",
    "DiagnosisResult": "testbed.library.diagnoses",
    "diagnose": "testbed.library.diagnoses",
    "InertiaEstimate": "testbed.library.estimates",
    "estimate": "testbed.library.estimates",
    "export": "testbed.library.exporting",
    "ImportedRecords": "testbed.library.imports",
    "guess_map": "testbed.library.imports",
    "import_log": "testbed.library.imports",
    "FlightPlan": "testbed.library.plans",
    "plan": "testbed.library.plans",
    "Records": "testbed.library.records",
    "frame_of": "testbed.library.records",
    "read_records": "testbed.library.records",
    "records_from": "testbed.library.records",
    "Maneuver": "testbed.library.runs",
    "Run": "testbed.library.runs",
    "design": "testbed.library.runs",
    "fly": "testbed.library.runs",
    "read_scenario": "testbed.library.scenarios",
    "shipped_scenarios": "testbed.scenario.shipped",
}
"""Module of each name."""

__all__ = sorted(["__version__", "effects", *_HOMES])  # noqa: PLE0605 - a list of the names above


def __getattr__(name: str) -> Any:  # noqa: ANN401 - as many types as names
    if name == "__version__":
        return version("testbed")
    if name == "effects":
        return import_module("testbed.effects")
    if name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'testbed' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
