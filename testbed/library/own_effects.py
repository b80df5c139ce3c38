"""Effects of the user's own library: formulas that diagnoses named."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from testbed.dynamics.inertia import inertia_of
from testbed.effects.formula import ID
from testbed.effects.library import KeptFormula, keep
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError, words_of
from testbed.files import read_text, require_folder
from testbed.formulas.pattern import pattern_of

_LARGEST = 100_000_000
"""Bytes of a diagnosis; one of a hundred runs has 10 MB."""
_AXES = 3
"""Of the mean moment of inertia: a third of the trace."""


def save_effect(diagnosis: str | Path, name: str, number: int | None = None) -> Path:
    """Keep a formula that a diagnosis named as an effect, which later diagnoses know by its name, and return its file.

    Args:
        diagnosis: folder that `testbed diagnose` has written.
        name: of the effect.
        number: which formula, from 1, where the diagnosis named several.

    Raises:
        InputError: the folder holds no diagnosis with a formula, the name is none or is taken, or nothing can be
            written.
    """
    require_folder(Path(diagnosis))
    path = Path(diagnosis) / "diagnosis.json"
    if not path.is_file():
        raise InputError(f"{diagnosis}: holds no diagnosis.json; name the folder of a diagnosis")
    try:
        content = json.loads(read_text(path, "a diagnosis", _LARGEST).text)
        found = [step for step in content["steps"] if step["effect"] == ID]
        theta = np.array(content["inertia"]["after"]["theta_kg_m2"], dtype=np.float64)
        moment = float(np.trace(inertia_of(theta))) / _AXES
        step = _chosen(path, found, number)
        kept = _kept(step, name, moment, str(path))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: is not as testbed wrote it ({words_of(error)}); diagnose again") from error
    return keep(kept, [*EFFECTS, *NOISE_EFFECTS, ID])


def _chosen(path: Path, found: list[Mapping[str, Any]], number: int | None) -> Mapping[str, Any]:
    if not found:
        raise InputError(f"{path}: names no formula; what the library lists need not be kept")
    if number is None and len(found) > 1:
        listed = "; ".join(f"{index}: {step['component']}" for index, step in enumerate(found, start=1))
        raise InputError(f"{path}: names {len(found)} formulas; choose one by its number (--number): {listed}")
    if number is not None and not 1 <= number <= len(found):
        raise InputError(f"{path}: has no formula {number}; there are {len(found)}")
    return found[(number or 1) - 1]


def _kept(step: Mapping[str, Any], name: str, moment: float, source: str) -> KeptFormula:
    pattern = pattern_of(step["component"])
    values = [float(each["value"]) for each in step["parameters"].values()]
    count = len(pattern.names)
    sizes = np.array(values[count:]).reshape(len(pattern.laws), len(pattern.axes))
    return KeptFormula(
        name=name,
        formula=str(pattern),
        constants=tuple(values[:count]),
        sizes=tuple(np.linalg.norm(sizes, axis=1).tolist()),
        mean_inertia_kg_m2=moment,
        source=source,
    )
