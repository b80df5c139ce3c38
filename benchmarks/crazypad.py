"""What the diagnosis names in the flights of a quadcopter with known defects, its healthy flights being the reference.

Run with `python -m benchmarks.crazypad`, or with names of the folders in data/crazypad that are to be diagnosed; the
last lines are a table of all of them. The healthy records that are fitted are the reference; those held out are
diagnosed like the defective ones, so that nothing should be new in them. `python -m benchmarks.crazypad torque` shows
without any diagnosis what commands and motion have to do with each other: the mean torque of every flight, and the
response of the angular acceleration. `python -m benchmarks.crazypad weaker` diagnoses healthy flights in which a motor
needs a third more of its command: a weak motor in a loop, as exactly as it can be known.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.linalg import eigvalsh
from scipy.signal import csd

from testbed.arrays import Array
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.keeping import Content, Store
from testbed.dynamics.inertia import inertia_of
from testbed.library.diagnoses import DiagnosisResult, diagnose
from testbed.library.records import Records
from testbed.records.reading import read_data_set
from testbed.records.record import Record
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario

DATA = Path(__file__).resolve().parents[1] / "data" / "crazypad"
HEALTHY = "normal"
TRUE = {
    HEALTHY: "nothing is new",
    "propeller_3_cut_3_mm": "actuator_weak:3",
    "tape_on_propeller_3": "an effect of actuator 3",
    "weight_between_motors_3_4": "thrust_offset, towards +y",
}
"""What is known of each folder."""
WEAKER, LOST = ("log01", "log02"), 0.25
"""Healthy logs in which a motor is made weaker, and by which share."""


def main() -> None:
    """Print a row for each folder."""
    if sys.argv[1:] == ["torque"]:
        for line in torque_lines():
            print(line)
        return
    if sys.argv[1:] == ["weaker"]:
        for line in weaker_lines():
            print(line, flush=True)
        return
    kept, rows = Kept(), ["| flights | known | verdict | names | probability |", "|---|---|---|---|---|"]
    for name in sys.argv[1:] or TRUE:
        result = diagnosed(name, kept)
        print(f"{name}: {result.verdict}; known: {TRUE[name]}")
        for line in lines_of(result):
            print(f"    {line}", flush=True)
        likeliest = max(result.probabilities.values())
        rows.append(f"| {name} | {TRUE[name]} | {result.verdict} | {names_of(result)} | {likeliest:.3f} |")
    print("\n".join(rows))


class Kept:
    """Parts of diagnoses in memory: that of the healthy flights is the same for every folder."""

    def __init__(self) -> None:
        self._parts: dict[str, Content] = {}

    def get(self, name: str) -> Content | None:
        """Return a part, as in `Store`."""
        return self._parts.get(name)

    def put(self, name: str, content: Content) -> None:
        """Keep a part, as in `Store`."""
        self._parts[name] = content


def diagnosed(name: str, kept: Store) -> DiagnosisResult:
    """Return the diagnosis of a folder against the healthy flights that are fitted.

    Args:
        name: of a folder in data/crazypad.
        kept: parts of earlier diagnoses.
    """
    healthy = [record for record in read_data_set(DATA / HEALTHY) if record.details.role == "fit"]
    scenario = read_body_scenario(shipped_scenario("crazypad"))
    reference, suspect = Records(tuple(healthy)), Records(suspect_records(name))
    return diagnose(scenario, suspect, reference=reference, keep=kept, propose=False)


def suspect_records(name: str) -> tuple[Record, ...]:
    """Return the records of a folder; of the healthy one those that are held out, dealt to both roles anew."""
    records = read_data_set(DATA / name)
    if name != HEALTHY:
        return records
    return dealt_anew(record for record in records if record.details.role == "heldout")


def dealt_anew(records: Iterable[Record]) -> tuple[Record, ...]:
    """Return records without the roles that they state."""
    return tuple(replace(record, details=replace(record.details, role=None)) for record in records)


def weaker_lines() -> Iterator[str]:
    """Yield what is named where a motor of two healthy logs gives a quarter less; the other logs are the reference."""
    scenario, kept = read_body_scenario(shipped_scenario("crazypad")), Kept()
    records = dealt_anew(read_data_set(DATA / HEALTHY))
    suspect = [each for each in records if each.details.name.startswith(WEAKER)]
    reference = Records(tuple(each for each in records if not each.details.name.startswith(WEAKER)))
    for motor in range(4):
        weaker = Records(tuple(with_weak_motor(each, motor) for each in suspect))
        result = diagnose(scenario, weaker, reference=reference, keep=kept, propose=False)
        yield f"motor {motor + 1} a quarter weaker: {result.verdict}, {names_of(result)}"


def with_weak_motor(record: Record, motor: int) -> Record:
    """Return a flight whose controller has found what a weak motor needs: for the same thrust a larger command.

    Args:
        record: healthy; the torque that its commands would make is taken from these.
        motor: index of the weak one.
    """
    thrust = record.channels["motor_thrust"].copy()
    thrust[:, motor] /= 1.0 - LOST
    others = {name: values for name, values in record.channels.items() if name != "applied_torque"}
    return replace(record, channels={**others, "motor_thrust": thrust})


def torque_lines() -> Iterator[str]:
    """Yield the mean torque of every flight, and how the healthy ones answer to their torque by frequency."""
    for name in TRUE:
        for record in read_data_set(DATA / name):
            mean = record.channels["applied_torque"].mean(axis=0)
            yield f"{name}/{record.details.name}: mean torque {np.array2string(1e4 * mean, precision=1)} 1e-4 N m"
    inertia = nominal_body(read_body_scenario(shipped_scenario("crazypad"))).inertia
    records = read_data_set(DATA / HEALTHY)
    for axis, letter in enumerate("xyz"):
        spectra = [_spectra(record, axis, inertia[axis, axis]) for record in records]
        frequency = spectra[0][0]
        asked, turned, both = (np.mean([each[part] for each in spectra], axis=0) for part in (1, 2, 3))
        response, coherence = both[1:] / asked[1:], np.abs(both[1:]) ** 2 / (asked[1:] * turned[1:])
        for index in range(0, 12, 2):
            yield (
                f"{letter} {frequency[1 + index]:.0f} Hz: acceleration over torque / J {abs(response[index]):.2f}, "
                f"phase {np.degrees(np.angle(response[index])):.0f} deg, coherence {coherence[index].real:.2f}"
            )


def _spectra(record: Record, axis: int, moment: float) -> tuple[Array, Array, Array, Array]:
    """Return frequencies, Hz, and the densities of the torque over J, of the acceleration and of both together."""
    asked, rate = record.channels["applied_torque"][:, axis] / moment, record.channels["body_rate"][:, axis]
    sampled = float(1.0 / np.median(np.diff(record.time)))
    settings = {"fs": sampled, "nperseg": round(sampled)}
    frequency, power = csd(asked, asked, **settings)
    _, of_rate = csd(rate, rate, **settings)
    _, both = csd(asked, rate, **settings)
    turning = 2j * np.pi * frequency
    return frequency, power.real, of_rate.real * np.abs(turning) ** 2, both * turning


def names_of(result: DiagnosisResult) -> str:
    """Return what was named, with what cannot be distinguished from it."""
    return ", ".join(["; ".join(map(repr, result.steps)) or "none", *(f"or {each}" for each in alike_of(result))])


def alike_of(result: DiagnosisResult) -> list[str]:
    """Return the effects that cannot be distinguished from those that were named."""
    return [f"{each.effect.id}:{each.component}" for step in result.steps for each in step.look_alikes]


def lines_of(result: DiagnosisResult) -> Iterator[str]:
    """Yield names with their classes, the inertia's ratios to the nominal one, and probabilities."""
    for step in result.steps:
        yield repr(step)
    if alike := alike_of(result):
        yield f"indistinguishable: {', '.join(alike)}"
    state = result.state
    ratios = eigvalsh(inertia_of(state.model.theta), inertia_of(state.nominal_theta))
    yield f"inertia over nominal {np.array2string(ratios, precision=2)}"
    likely = sorted(result.probabilities.items(), key=lambda item: -item[1])[:3]
    yield "; ".join(f"{explanation} {probability:.3f}" for explanation, probability in likely)


if __name__ == "__main__":
    main()
