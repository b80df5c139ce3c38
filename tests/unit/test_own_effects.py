"""An effect of another package: found by its entry point, and diagnosed like those of the library."""

# ruff: noqa: ARG001, ARG002, ARG005 - hooks take what the contract gives them

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib

import numpy as np
import pytest

import testbed as tb
from support.diagnosed_records import SCENARIO, records
from support.processes import ROOT
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.effects.checking import require_usable
from testbed.effects.registry import EFFECTS
from testbed.records.writing import write_record

EXAMPLE = ROOT / "examples" / "own_effect"
DIAGNOSED = """
import json
import numpy as np
from testbed.effects.registry import EFFECTS
for name in set(EFFECTS) - {"inertia", "viscous_drag", "gyro_latency", "body_torque", "bearing_friction"}:
    del EFFECTS[name]
import testbed as tb
from support.diagnosed_records import records

class Braked(tb.Hooks):
    def torque(self, value, at):
        speed = np.sqrt((at.body_rate.real**2).sum(axis=-1, keepdims=True))
        return -value * np.tanh(speed / 1e-3) * at.body_rate / speed

runs = records(5, seconds=6.0, hooks=[Braked()], values=[np.array([4e-5])])
found = tb.diagnose(tb.read_scenario("diagnose"), tb.Records(tuple(runs)), propose=False)
size = found.steps[0].quantities[0]
print(json.dumps([found.verdict, found.steps[0].effect.id, size.value, size.std]))
"""


def environment(place):
    """Return an environment in which the example is installed in a folder."""
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    shutil.copy(EXAMPLE / "dry_friction.py", place)
    installed = place / "dry_friction-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 1.0\n")
    ((group, entries),) = project["entry-points"].items()
    lines = [f"{name} = {value}" for name, value in entries.items()]
    (installed / "entry_points.txt").write_text("\n".join([f"[{group}]", *lines]) + "\n")
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(place), str(ROOT)])}


def test_an_installed_effect_is_named_with_its_size(tmp_path):
    """What hides it is another law of the same kind: tanh of the speed, where the effect has a root."""
    ran = subprocess.run(
        [sys.executable, "-c", DIAGNOSED], env=environment(tmp_path), capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    verdict, effect, value, std = json.loads(ran.stdout)
    assert (verdict, effect) == ("named", "bearing_friction")
    assert abs(value - 4e-5) < 4.0 * std + 0.02 * 4e-5  # the two laws differ by 2 % below 5e-3 rad/s


def test_an_installed_effect_that_looks_like_none_that_there_is_is_named(tmp_path):
    surroundings = environment(tmp_path)
    module = tmp_path / "dry_friction.py"
    module.write_text(module.read_text(encoding="utf-8").replace('("viscous_drag",)', '("viscous_drug",)'))
    command = [sys.executable, "-m", "testbed", "diagnose", "diagnose", "--data", str(tmp_path)]
    ran = subprocess.run(command, env=surroundings, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 2
    assert "look_alikes name 'viscous_drug', which is no effect; did you mean viscous_drag" in ran.stderr


def test_an_installed_effect_that_fails_to_load_is_named(tmp_path):
    surroundings = environment(tmp_path)
    (tmp_path / "dry_friction.py").write_text("raise RuntimeError('no such bearing')\n")
    ran = subprocess.run(
        [sys.executable, "-m", "testbed", "diagnose", "diagnose", "--data", str(tmp_path)],
        env=surroundings,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 2
    assert "the effect dry_friction of dry_friction:DryFriction cannot be used: no such bearing" in ran.stderr


def test_the_example_is_short():
    assert len((EXAMPLE / "dry_friction.py").read_text(encoding="utf-8").splitlines()) < 40


def test_what_is_no_effect_is_refused():
    with pytest.raises(tb.InputError, match=r"derive its class from testbed\.Effect"):
        tb.register_effect(object())
    with pytest.raises(tb.InputError, match=r"viscous_drag: an effect of this id is registered already"):
        tb.register_effect(EFFECTS["viscous_drag"])
    assert set(EFFECTS) < set(tb.effects.registered())


class Square(tb.Hooks):
    """A scale factor that grows with the rate."""

    def gyro_reading(self, reading, value, time, run):
        return reading + value[:, :1, None] * reading**2


class Own(tb.Effect):
    """As in docs/effects.md."""

    id = "own_square"
    components = ("gyro",)
    parameters = (tb.Parameter(name="share_s_rad", unit="s/rad", typical=0.02),)
    sentence = "The gyro's scale grows with the rate."
    confirm = "A rate table."
    law = Square

    def hooks(self, component):
        return self.law()

    def extension(self, component, values, scenario):
        return tb.Extension()


class Misspelt(tb.Hooks):
    def gyro_readings(self, reading, value, time, run):
        return reading


def own(**changes):
    return type("Changed", (Own,), changes)()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"id": "own square"}, "is no name in small letters"),
        ({"components": "gyro"}, "components = 'gyro' is no tuple of names"),
        ({"look_alikes": "gyro_scale"}, "look_alikes = 'gyro_scale' is no tuple"),
        ({"components": ()}, "components has no entry"),
        ({"needs": ("gimbal",)}, "needs 'gimbal', which is none of"),
        ({"sentence": None}, "sentence is no sentence"),
        ({"parameters": ()}, "at least one"),
        ({"parameters": Own.parameters * 2}, "two of its parameters have one name"),
        ({"parameters": (tb.Parameter(name="k", unit="1", typical=0.0),)}, "is where the effect is absent"),
        (
            {"parameters": (tb.Parameter(name="k", unit="1", typical=1.0, lower=2.0, upper=1.0),)},
            "is not below its upper",
        ),
        ({"parameters": (tb.Parameter(name="k", unit="1", typical=1.0, lower=0.5),)}, "absent = 0 lies outside"),
        ({"parameters": (tb.Parameter(name="k", unit="1", typical="a"),)}, "k: no number: typical = 'a'"),
        ({"law": lambda _: None}, "returns None and no testbed.Hooks"),
        ({"law": tb.Hooks}, "changes nothing in the prediction; override one of"),
        ({"law": Misspelt}, "gyro_readings: did you mean gyro_reading"),
        (
            {"hooks": lambda self, component: component.law},
            "raises AttributeError: 'str' object",
        ),
    ],
)
def test_an_effect_that_does_not_keep_the_contract_is_refused_where_it_is_registered(changes, said):
    with pytest.raises(tb.InputError, match=said):
        tb.register_effect(own(**changes))
    assert "own_square" not in EFFECTS


def test_every_effect_of_the_library_keeps_the_contract():
    for effect in EFFECTS.values():
        require_usable(effect)


def forgotten(self, reading, value, time, run):
    reading + value[:, :1, None] * reading**2


def undefined(self, reading, value, time, run):
    raise NameError("name 'rates' is not defined")


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (lambda self, reading, value, time, run: reading + value * reading**2, r"broadcast.*test_own_effects.py, line"),
        (lambda self, reading, value, time, run: reading.rates, r"no attribute 'rates' \(test_own_effects.py, line"),
        (undefined, r"own_square.*'rates' is not defined \(test_own_effects.py, line"),
        (forgotten, "own_square: this effect cannot be predicted"),
    ],
)
def test_a_slip_in_a_hook_ends_the_diagnosis_and_is_named_with_its_line(law, said, monkeypatch):
    monkeypatch.setitem(EFFECTS, "own_square", own(law=type("Slip", (tb.Hooks,), {"gyro_reading": law})))
    runs = tb.Records(tuple(records(3, seconds=3.0)))
    with pytest.raises(tb.InputError, match=said):
        tb.diagnose(tb.read_scenario("diagnose"), runs, propose=False)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (lambda reading, value: reading + value * np.nan, "predicts where it is absent is no number"),
        (lambda reading, value: reading + value * reading**2 + 0.05, "should be absent, it moves a sample by"),
        (lambda reading, value: reading + value.real * reading**2, "its derivative by share_s_rad is not that of"),
        (lambda reading, value: reading + value * np.abs(reading) ** 2, "its derivative by the inertia is not that of"),
    ],
)
def test_what_breaks_the_contract_on_the_runs_at_hand_is_refused_and_nobodys_units_are_blamed(
    law, said, monkeypatch, tmp_path, capsys
):
    def gyro_reading(self, reading, value, *_):
        return law(reading, value[:, :1, None])

    hooks = type("Broken", (tb.Hooks,), {"gyro_reading": gyro_reading})
    monkeypatch.setitem(EFFECTS, "own_square", own(law=hooks))
    data = tmp_path / "data"
    data.mkdir()
    for record in records(3, seconds=3.0):
        write_record(record, data / f"{record.details.name}.csv")
    command = ["diagnose", str(SCENARIO), "--data", str(data), "--out", str(tmp_path / "out")]
    assert exit_code_of(lambda: app(command)) == 2
    printed = capsys.readouterr().err
    assert "own_square:gyro: this effect cannot be predicted" in printed
    assert said in " ".join(printed.split())
    assert not (tmp_path / "out").exists()
