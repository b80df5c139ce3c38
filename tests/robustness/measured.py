"""Measured flights with something done to them that happens to logs: pieces cut, channels lost, other clocks and units.

Nobody knows what a diagnosis of them should say; it has to end with a verdict or with a message, within its time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pyarrow.parquet

from tests.robustness.case import ANY, Case
from tests.robustness.records import Columns, as_csv, as_parquet

DATA = Path(__file__).resolve().parents[2] / "data"
TIME = "time_s"
_MOST_CHANGES = 3
"""Of one set of records; the first of them in every record, the others in one of them each."""
_LONGEST, _SHORTEST = 5.0, 0.1
"""Seconds of a piece: long enough to be diagnosed, short enough for hundreds of diagnoses."""
_PATIENCE = 3_600.0
"""Wall time, s, of a diagnosis that takes a minute alone, beside as many others as there may be."""
_MEMORY = 2_500.0
"""Megabytes; those of a user's machine, not of the small records elsewhere."""

Change: TypeAlias = Callable[[Columns, np.random.Generator], Columns]


@dataclass(frozen=True)
class _Source:
    """Flights to take pieces of, with the scenario that believes it knows the aircraft."""

    scenario: str
    folder: str


SOURCES = (
    _Source("crazyflie", "crazyflie"),
    _Source("crazypad", "crazypad/normal"),
    _Source("crazypad", "crazypad/propeller_3_cut_3_mm"),
    _Source("crazypad", "crazypad/weight_between_motors_3_4"),
)


def measured_cases(number: int, seed: int) -> Iterator[Case]:
    """Yield sets of two to four mutated records, each to be diagnosed.

    Args:
        number: of cases.
        seed: of what is drawn; case k of a seed is the same whatever the number.
    """
    for index in range(number):
        rng = np.random.default_rng([seed, index])
        source = SOURCES[index % len(SOURCES)]
        names = list(CHANGES)
        drawn = [names[place] for place in rng.choice(len(names), rng.integers(1, _MOST_CHANGES + 1), replace=False)]
        yield Case(
            name=f"measured {seed}/{index} {source.folder}: {', '.join(drawn)}",
            prepare=_prepared(source, drawn, rng),
            commands=(("diagnose", source.scenario, "--data", "data", "--out", "out", "--quiet"),),
            codes=ANY,
            seconds=_PATIENCE,
            megabytes=_MEMORY,
        )


def _prepared(source: _Source, drawn: list[str], rng: np.random.Generator) -> Callable[[Path], None]:
    def prepare(folder: Path) -> None:
        (folder / "data").mkdir()
        flights = sorted((DATA / source.folder).glob("*.parquet"))
        chosen = rng.choice(len(flights), min(len(flights), int(rng.integers(2, 5))), replace=False)
        records = [_piece(_columns_of(flights[flight]), rng) for flight in chosen]
        first, *others = (CHANGES[name] for name in drawn)
        records = [first(columns, rng) for columns in records]
        for change in others:
            place = int(rng.integers(len(records)))
            records[place] = change(records[place], rng)
        for place, (flight, columns) in enumerate(zip(chosen, records, strict=True)):
            _write(columns, folder / "data" / f"run_{place}", flights[flight], rng)

    return prepare


def _columns_of(flight: Path) -> Columns:
    table = pyarrow.parquet.read_table(flight)
    return {name: table[name].to_numpy() for name in table.column_names}


def _write(columns: Columns, stem: Path, flight: Path, rng: np.random.Generator) -> None:
    """Write a record with what is stated of its flight, as one of the two formats."""
    suffix, written = (".parquet", as_parquet) if rng.random() < 0.5 else (".csv", as_csv)
    stem.with_suffix(suffix).write_bytes(written(columns))
    stated = flight.with_suffix(".toml").read_text(encoding="utf-8").splitlines()
    stem.with_suffix(".toml").write_text("\n".join(line for line in stated if not line.startswith("name")) + "\n")


def _rows(columns: Columns, chosen: slice | np.ndarray) -> Columns:
    return {name: values[chosen] for name, values in columns.items()}


def _piece(columns: Columns, rng: np.random.Generator, shortest: float = 1.0) -> Columns:
    time = columns[TIME]
    length = rng.uniform(shortest, _LONGEST)
    start = rng.uniform(time[0], max(time[0], time[-1] - length))
    return _rows(columns, (time >= start) & (time <= start + length))


def _without_a_stretch(columns: Columns, rng: np.random.Generator) -> Columns:
    first, last = np.sort(rng.integers(0, len(columns[TIME]), 2))
    return _rows(columns, np.r_[0:first, last : len(columns[TIME])])


def _channels(columns: Columns, start: str = "") -> list[str]:
    return [name for name in columns if name != TIME and name.startswith(start)]


def _one_of(names: list[str], rng: np.random.Generator) -> str:
    return names[int(rng.integers(len(names)))]


def _without_a_channel(columns: Columns, rng: np.random.Generator) -> Columns:
    lost = _one_of(_channels(columns), rng)
    return {name: values for name, values in columns.items() if name != lost}


def _changed(columns: Columns, rng: np.random.Generator, change: Callable[[np.ndarray], np.ndarray]) -> Columns:
    """Return the same with one channel, drawn, changed."""
    name = _one_of(_channels(columns), rng)
    return columns | {name: change(columns[name].astype(float))}


def _emptied(columns: Columns, rng: np.random.Generator) -> Columns:
    first, last = np.sort(rng.integers(0, len(columns[TIME]) + 1, 2))

    def change(values: np.ndarray) -> np.ndarray:
        values[first:last] = np.nan
        return values

    return _changed(columns, rng, change)


def _stuck(columns: Columns, rng: np.random.Generator) -> Columns:
    since = int(rng.integers(len(columns[TIME])))
    return _changed(columns, rng, lambda values: np.where(np.arange(len(values)) < since, values, values[since]))


def _with_spikes(columns: Columns, rng: np.random.Generator) -> Columns:
    def change(values: np.ndarray) -> np.ndarray:
        hit = rng.random(len(values)) < 0.01
        return values + hit * rng.standard_normal(len(values)) * 100.0 * (np.std(values) + 1e-9)

    return _changed(columns, rng, change)


def _group(columns: Columns, rng: np.random.Generator) -> list[str]:
    return _channels(columns, ("body_rate", "applied_torque")[int(rng.integers(2))])


def _shifted(columns: Columns, rng: np.random.Generator) -> Columns:
    by = int(rng.integers(-60, 61))
    return columns | {name: np.roll(columns[name], by) for name in _group(columns, rng)}


def _scaled(columns: Columns, rng: np.random.Generator, factors: tuple[float, ...]) -> Columns:
    factor = factors[int(rng.integers(len(factors)))]
    return columns | {name: columns[name] * factor for name in _group(columns, rng)}


def _swapped(columns: Columns, rng: np.random.Generator) -> Columns:
    names = _group(columns, rng)
    return columns | dict(zip(names, (columns[name] for name in rng.permutation(names)), strict=True))


def _with_time(columns: Columns, change: Callable[[np.ndarray], np.ndarray]) -> Columns:
    return columns | {TIME: change(columns[TIME].astype(float))}


CHANGES: dict[str, Change] = {
    "pieces cut": lambda columns, rng: _piece(columns, rng, _SHORTEST),
    "a stretch is missing": _without_a_stretch,
    "every fifth sample": lambda columns, _: _rows(columns, slice(None, None, 5)),
    "a third of the samples lost": lambda columns, rng: _rows(columns, rng.random(len(columns[TIME])) > 1.0 / 3.0),
    "samples twice": lambda columns, rng: _rows(
        columns, np.sort(np.r_[: len(columns[TIME]), rng.integers(0, len(columns[TIME]), 20)])
    ),
    "samples out of order": lambda columns, rng: _rows(columns, rng.permutation(len(columns[TIME]))),
    "a channel lost": _without_a_channel,
    "a channel empty for a while": _emptied,
    "a channel stuck": _stuck,
    "spikes": _with_spikes,
    "saturated": lambda columns, rng: _changed(
        columns, rng, lambda values: np.clip(values, *np.nanquantile(values, (0.2, 0.8)))
    ),
    "coarse": lambda columns, rng: _changed(
        columns, rng, lambda values: np.round(values / (np.std(values) + 1e-12)) * np.std(values)
    ),
    "noisy": lambda columns, rng: _changed(
        columns, rng, lambda values: values + np.std(values) * rng.standard_normal(len(values))
    ),
    "an offset": lambda columns, rng: _changed(columns, rng, lambda values: values + 3.0 * np.std(values)),
    "infinite values": lambda columns, rng: _changed(
        columns, rng, lambda values: np.where(rng.random(len(values)) < 0.001, np.inf, values)
    ),
    "one stream late or early": _shifted,
    "a clock that runs fast": lambda columns, rng: _with_time(columns, lambda time: time * rng.uniform(0.95, 1.05)),
    "time in milliseconds": lambda columns, _: _with_time(columns, lambda time: 1e3 * time),
    "time since 1970": lambda columns, _: _with_time(columns, lambda time: time + 1.7e9),
    "time with jitter": lambda columns, rng: _with_time(
        columns, lambda time: np.sort(time + 0.5 * np.median(np.diff(time)) * rng.standard_normal(len(time)))
    ),
    "other units": lambda columns, rng: _scaled(columns, rng, (np.degrees(1.0), 1e3, 1e-3, 0.01, 8.85)),
    "a wrong sign": lambda columns, rng: _scaled(columns, rng, (-1.0,)),
    "axes exchanged": _swapped,
}
"""What is done to a record, by name."""
