"""A data set as a folder of records, and its answer sealed in another; what is lost and spoilt on the way."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from concealing.craft import Array
from concealing.effect import EffectKind, HiddenEffect
from testbed.records.record import Record
from testbed.records.writing import write_record

_DROPOUTS, _OUTLIERS, _SALT = range(3, 6)
"""Purposes of a case's random numbers, beside those of its flight."""
_BURST = 3
_SPIKE = (8.0, 30.0)
_OTHER_NAMES = {("contact", "time"): "time_since_release", ("slosh", "mass"): "loose_mass"}
"""Of parameters whose plain name would mean something else to a diagnosis: an instant in all runs laid end to end, and
the mass that would swing as this one does at an arm that is agreed on."""
SEAL = "sealed.sha256"


def write_sealed(answer: str, records: Sequence[Record], data_folder: Path, answer_folder: Path) -> None:
    """Write records as run_1.csv ..., the answer as answer.json, and the answer's hash beside the records.

    Args:
        answer: its text.
        records: in the order of their files.
        data_folder: new or empty.
        answer_folder: new or empty; another one.
    """
    _write(answer_folder / "answer.json", answer)
    for index, record in enumerate(records):
        write_record(record, data_folder / f"run_{index + 1}.csv")
    _write(data_folder / SEAL, hashlib.sha256(answer.encode()).hexdigest() + "\n")  # last: the set is whole


def is_sealed(data_folder: Path, answer_folder: Path) -> bool:
    """Return whether an answer is the one that was sealed when the data were made."""
    answer = (answer_folder / "answer.json").read_bytes()
    return hashlib.sha256(answer).hexdigest() == (data_folder / SEAL).read_text(encoding="utf-8").strip()


def sealed_text(
    seed: int,
    stratum: str,
    effects: Sequence[HiddenEffect],
    kinds: Mapping[str, EffectKind],
    content: Mapping[str, Any],
) -> str:
    """Return an answer as text, salted, so that no hash tells.

    Args:
        seed: of the case.
        stratum: part of the score card.
        effects: that are hidden.
        kinds: by id.
        content: what else there is to say.
    """
    salt = np.random.default_rng([seed, _SALT]).bytes(32).hex()
    hidden = [
        {
            "effect": each.effect,
            "component": each.component,
            "parameters": {
                file_key(each.effect, name, kinds[each.effect].units[name]): {
                    "value": value,
                    "unit": kinds[each.effect].units[name],
                }
                for name, value in each.parameters.items()
            },
        }
        for each in effects
    ]
    answer = {"schema": 1, "stratum": stratum, "effects": hidden, **content, "salt": salt}
    return json.dumps(answer, indent=1) + "\n"


def file_key(effect: str, name: str, unit: str) -> str:
    """Return a parameter's name as files spell it: delay_s, impulse_x_N_m_s, frequency_hz."""
    name = _OTHER_NAMES.get((effect, name), name)
    suffix = {"1": "", "Hz": "hz", "rad/s/√s": "rad_s_per_sqrt_s"}.get(unit, unit.replace("/", "_").replace(" ", "_"))
    return f"{name}_{suffix}" if suffix else name


def spiked(seed: int, index: int, share: float, gyro: Array, noise: float) -> Array:
    """Replace a share of a run's gyro samples, (N, 3), by spikes on one axis.

    Args:
        seed: of the case.
        index: of the run.
        share: of the samples.
        gyro: readings, rad/s.
        noise: of the gyro, rad/s, in which spikes are counted.
    """
    rng = _generator(seed, _OUTLIERS, index)
    hit = rng.random(len(gyro)) < share
    size = rng.choice((-1.0, 1.0), len(gyro)) * rng.uniform(*_SPIKE, len(gyro)) * noise
    spikes = np.zeros_like(gyro)
    spikes[np.arange(len(gyro)), rng.integers(0, 3, len(gyro))] = hit * size
    return gyro + spikes


def kept_rows(seed: int, index: int, share: float, rows: int) -> Array:
    """Return which rows of a run came through: bursts of them are lost, the first and the last never."""
    rng = _generator(seed, _DROPOUTS, index)
    begins = rng.random(rows) < share / _BURST
    lost = np.convolve(begins, np.ones(_BURST), mode="full")[:rows] > 0
    lost[[0, -1]] = False
    return ~lost


def _generator(seed: int, purpose: int, index: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(purpose,)).spawn(index + 1)[index])


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
