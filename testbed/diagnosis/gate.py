"""The gate in front of every answer from measured records: are they in SI, of this platform, and on one clock?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from testbed.assembly.platform import Body
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit
from testbed.diagnosis.parts import Part, parts_of
from testbed.diagnosis.plausibility import require_motion, require_si, require_this_platform
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.records.record import Record
from testbed.scenario.body import BodyScenario

Usable: TypeAlias = list[tuple[Record, tuple[Part, ...]]]
"""Records with the parts of them that can be predicted."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gated:
    """Records that have passed.

    Attributes:
        usable: these, with the parts of them that can be predicted.
        refused: why others cannot be used.
        notices: what a reader has to know of a record, by its name.
        together: all parts as runs.
        baseline: the nominal model fitted to them.
    """

    usable: Usable
    refused: tuple[str, ...]
    notices: tuple[tuple[str, str], ...]
    together: Runs
    baseline: Fit


def gated(records: Sequence[Record], scenario: BodyScenario, nominal: Body, *, at_rest: bool = False) -> Gated:
    """Let records pass that can be meant for the scenario's platform.

    Args:
        records: measured.
        scenario: the gyro's noise where neither a record states it nor its samples tell it.
        nominal: geometry of the units, and the inertia that is believed.
        at_rest: whether platforms that hardly turn may pass, because what follows asks by itself what the motion tells.

    Raises:
        InputError: no record can be used, the records' channels differ, or they are of another platform or in other
            units, or hardly turn.
    """
    usable: Usable = []
    refused: list[str] = []
    notices: list[tuple[str, str]] = []
    for record in records:
        try:
            usable.append((record, tuple(parts_of(record, scenario, nominal, notices))))
        except InputError as error:
            refused.append(str(error))
    if not usable:
        raise InputError("\n".join(refused))
    theta = theta_of(nominal.inertia)
    together = runs_together(usable, range(len(usable)))
    if not at_rest:
        require_motion(together)
    require_si(together, theta)
    baseline = fitted(together, [], theta, [])
    require_this_platform(together, baseline, theta)
    return Gated(usable=usable, refused=tuple(refused), notices=tuple(notices), together=together, baseline=baseline)


def runs_together(usable: Usable, chosen: Sequence[int]) -> Runs:
    """Return the parts of some records as runs."""
    parts = [part for index in chosen for part in usable[index][1]]
    runs = runs_of([part.name for part in parts], [part.telemetry for part in parts])
    return replace(runs, windowed=tuple(part.stretch for part in parts if part.stretch is not None))


def grouped(notices: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield what there is to know of records, once for all of which the same is true."""
    for text in dict.fromkeys(text for _, text in notices):
        names = [name for name, other in notices if other == text]
        yield f"{', '.join(names)}{', each' if len(names) > 1 else ''}: {text}"
