"""An effect of another package: found by its entry point, and diagnosed like those of the library."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib

import pytest

import testbed as tb
from support.processes import ROOT
from testbed.effects.registry import EFFECTS

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
