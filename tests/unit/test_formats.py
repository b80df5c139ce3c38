"""The published schemas describe what the testbed writes, key by key: what a writer adds or loses is seen here."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import testbed as tb
from support.diagnosed_records import NOISE, SCENARIO, records
from support.few_effects import know_only
from support.processes import ROOT
from support.unlisted_torques import Pulsing
from testbed.diagnosis.location import located
from testbed.effects.registry import EFFECTS
from testbed.formats.published import FORMATS, SCHEMAS, file_schema, published
from testbed.library.diagnoses import concluded
from testbed.library.prepared_records import prepared_records
from testbed.scenario.tables import unit_of
from tests.unit.test_diagnose_command import quadcopter, slow_roll

MAY_BE_ABSENT = {"constant_torque_N_m", "constant_torque_std_N_m", "next", "component"}
MAY_BE_ABSENT |= {"gimbal_rate", "gimbal_torque", "wheel_torque", "wheel_speed"}  # limits of what a platform has not
MAY_BE_ABSENT |= {"center_of_mass_offset_m", "center_of_mass_offset_std_m", "bound_center_of_mass_offset_std_m"}
MAY_BE_ABSENT |= {"center_of_mass_offset", "largest_tilt_rad"}  # but on an air bearing
MAY_BE_ABSENT |= {"engine_check"}  # but with --check
MAY_BE_ABSENT |= {"unestimated"}  # where every estimator estimates every flight
MAY_BE_ABSENT |= {"healthy_theta_kg_m2", "differs_from_healthy_p_value"}  # but with --reference
MAY_BE_ABSENT |= {"persistence"}  # in diagnoses of before it was estimated
OPEN = {"Provenance", "FilesProvenance"}
"""What decides a result is not the same for all of them."""
NO_UNIT_IN_KEY = (
    "pure number|0 to 1|-1 to 1|standard deviations|`unit`|1 at the |1 where|: 1\\.|Fraction of|\\d/s|s⁴|, s\\.|bytes"
)
"""How a description says the unit where the key does not."""
COUNTS = {"schema", "seed", "size", "freedom", "runs", "run", "failed", "outliers", "flights"}
QUICK = {"maneuver.starts": 1}
ESTIMATED = {"estimation.initial_momentum": "estimated"}
TOO_FAST = ESTIMATED | {"initial.body_rate_rad_s": [2000.0, 1300.0, 600.0]}
"""rad/s; no step of 1.25 ms follows a body that turns by 3 rad in each."""


def parts(name):
    schema = file_schema(name)
    return {name: schema, **schema["$defs"]}


def numeric(node):
    forms = [*node.get("anyOf", ()), *([node["items"]] if "items" in node else ())]
    return node.get("type") in ("number", "integer") or any(map(numeric, forms))


@pytest.mark.parametrize("path", published(ROOT), ids=lambda path: path.name)
def test_what_is_published_is_current(path):
    """If this fails: python -m testbed.formats.published."""
    assert path.read_text(encoding="utf-8") == published(ROOT)[path]


@pytest.mark.parametrize("name", FORMATS)
def test_a_schema_is_closed_and_asks_for_every_key(name):
    Draft202012Validator.check_schema(file_schema(name))
    for title, part in parts(name).items():
        assert set(part["properties"]) - set(part["required"]) <= MAY_BE_ABSENT, title
        assert part["additionalProperties"] is False or title in OPEN, title


@pytest.mark.parametrize("name", FORMATS)
def test_every_key_is_described_and_every_number_with_its_unit(name):
    for title, part in parts(name).items():
        assert part["description"], title
        for key, node in part["properties"].items():
            said = node["description"]
            assert said.endswith("."), (title, key)
            if numeric(node) and key not in COUNTS:
                assert (unit_of(key) or ".") in said, (title, key)
                assert unit_of(key) or re.search(NO_UNIT_IN_KEY, said) or "logarithm" in said or "Chance" in said, key


def test_the_schemas_lie_in_the_package():
    assert {path.name for path in (ROOT / SCHEMAS).iterdir()} == {f"{name}.schema.json" for name in FORMATS}
    assert SCHEMAS.parts[0] == "testbed"


def require_valid(folder, name):
    """Refuse a file that its schema does not describe; return its content."""
    content = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    schema = json.loads((ROOT / SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))
    found = [f"{error.json_path}: {error.message}" for error in Draft202012Validator(schema).iter_errors(content)]
    assert not found, "\n".join(found)
    return content


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folders of runs of each kind."""
    place = tmp_path_factory.mktemp("runs")
    made = {
        "basic": tb.fly(tb.read_scenario("basic"), seed=1),
        "dispersed": tb.fly(tb.read_scenario("zero_g_campaign", QUICK), seed=2, draw=True),
        "diverged": tb.fly(tb.read_scenario("basic", TOO_FAST)),
        "alignments": tb.fly(tb.read_scenario("basic", ESTIMATED | {"estimation.alignments": True})),
        "constant_torque": tb.fly(tb.read_scenario("basic", {"estimation.constant_torque": "both"})),
    }
    return {kind: run.save(place / kind) for kind, run in made.items()}


def test_a_run_is_as_described(runs):
    found = {kind: require_valid(folder, "result") for kind, folder in runs.items()}
    assert found["diverged"]["outcome"] == "diverged"
    assert found["dispersed"]["design"] is not None
    assert found["alignments"]["alignments"] is not None
    assert all("constant_torque_N_m" in each for each in found["constant_torque"]["estimates"].values())


def test_a_campaign_is_as_described(tmp_path):
    tb.monte_carlo(tb.read_scenario("basic"), runs=3, seed=5, workers=1, folder=tmp_path / "campaign")
    require_valid(tmp_path / "campaign", "montecarlo")


def test_a_campaign_of_failures_is_as_described(tmp_path):
    tb.monte_carlo(tb.read_scenario("basic", TOO_FAST), runs=2, workers=1, folder=tmp_path / "campaign")
    content = require_valid(tmp_path / "campaign", "montecarlo")
    assert content["failed"] == len(content["failures"]) == 2


@pytest.mark.parametrize("kinds", [["basic"], ["basic", "dispersed"]])
def test_an_estimate_is_as_described(kinds, runs, tmp_path):
    records = tb.Records(tuple(tb.read_records(runs[kind]).runs[0] for kind in kinds))
    scenario = tb.read_scenario("basic", {"estimation.initial_momentum": "zero"})
    content = require_valid(tb.estimate(scenario, records).save(tmp_path / "estimate"), "estimates")
    assert len(content["records"]) == len(kinds)


def test_a_comparison_is_as_described(runs, tmp_path):
    require_valid(tb.compare([runs["basic"], runs["diverged"]]).save(tmp_path / "runs"), "comparison")
    campaigns = []
    for seed in (1, 2):
        campaigns.append(tmp_path / f"campaign_{seed}")
        tb.monte_carlo(tb.read_scenario("basic"), runs=2, seed=seed, workers=1, folder=campaigns[-1])
    require_valid(tb.compare(campaigns).save(tmp_path / "campaigns"), "comparison")


def diagnosed(monkeypatch, effects, used, scenario=SCENARIO, **options):
    """Return a diagnosis with few effects, which takes seconds."""
    know_only(monkeypatch, *effects)
    return tb.diagnose(tb.read_scenario(scenario), tb.Records(tuple(used)), **options)


def late_by(seconds, count=3, **options):
    return records(count, hooks=[EFFECTS["gyro_latency"].hooks("gyro")], values=[np.array([seconds])], **options)


def test_a_diagnosis_is_as_described_whatever_its_verdict(monkeypatch, tmp_path):
    few = ("gyro_latency", "viscous_drag", "gimbal_coulomb_friction")
    alike = ("gyro_latency", "gyro_bandwidth")
    pulsing = records(3, hooks=[Pulsing()], values=[np.array([6e-4])])
    made = {
        "none": diagnosed(monkeypatch, few, records(3)),
        "named": diagnosed(monkeypatch, few, late_by(0.02)),
        "ambiguous": diagnosed(monkeypatch, alike, late_by(0.02)),
        "unexplained": diagnosed(monkeypatch, ("gyro_latency", "body_torque"), pulsing),
    }
    for verdict, diagnosis in made.items():
        content = require_valid(diagnosis.save(tmp_path / verdict), "diagnosis")
        assert content["verdict"] == verdict
        assert ("next" in content) == (verdict == "ambiguous")
    assert content["torque_left"] is not None


def test_a_diagnosis_of_less_is_as_described(monkeypatch, tmp_path):
    alone = diagnosed(monkeypatch, ("gyro_latency",), late_by(0.02, 1))
    noisy = [replace(each, details=replace(each.details, gyro_noise=NOISE)) for each in records(3, noise=1.4 * NOISE)]
    body = diagnosed(
        monkeypatch,
        ("actuator_lag", "actuator_delay"),
        [slow_roll(number, delay=0.02) for number in (1, 2, 3)],
        quadcopter(tmp_path),
    )
    made = {"alone": alone, "noisy": diagnosed(monkeypatch, ("gyro_latency",), noisy), "body": body}
    found = {kind: require_valid(each.save(tmp_path / kind), "diagnosis") for kind, each in made.items()}
    assert found["alone"]["misfit"]["heldout_before"] is None
    assert [step["effect"] for step in found["noisy"]["steps"]] == ["gyro_noise"]
    assert found["body"]["model"] is None


def test_an_interrupted_diagnosis_is_as_described(monkeypatch, tmp_path):
    know_only(monkeypatch, "gyro_latency")
    made = prepared_records(tb.read_scenario(SCENARIO), tb.Records(tuple(late_by(0.02))))
    first = next(made.stages())
    folder = concluded(made, first, located(first.runs, first.baseline)).save(tmp_path / "diagnosis")
    content = require_valid(folder, "diagnosis")
    assert content["complete"] is False
    assert content["verdict"] is None
