"""An unmodelled torque that follows a formula: an effect like every other, whatever the formula is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import TYPICAL_INERTIA, Channel, Effect, Extension, Parameter, Quantity
from testbed.formulas.causes import cause_of, separating_flight
from testbed.formulas.pattern import Pattern
from testbed.formulas.words import law_words, measured_words, place_words
from testbed.prediction.formula_hooks import formula_hooks
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario

ID = "formula"
"""Of all formulas that nobody gave a name; which one it is stands in the component."""
CONSTANTS = {
    "f": Parameter(name="frequency_hz", unit="Hz", typical=1.0, lower=0.2, upper=7.9, absent=1.0, scanned=True),
    "tau": Parameter(name="time_constant_s", unit="s", typical=0.3, lower=0.01, upper=20.0, absent=0.3, scanned=True),
    "late": Parameter(name="delay_s", unit="s", typical=0.1, lower=0.02, upper=2.0, absent=0.1, scanned=True),
    "at": Parameter(
        name="time_s", unit="s", typical=0.8, lower=0.0, upper=1e4, absent=0.8, scanned=True, plausible=(0.0, 1e4)
    ),
    "width": Parameter(name="width_s", unit="s", typical=0.2, lower=0.02, upper=5.0, absent=0.2, scanned=True),
    "stretch": Parameter(name="stretch_rad", unit="rad", typical=0.1, lower=5e-3, upper=5.0, absent=0.1, scanned=True),
}
"""Constants that a search estimates. Bounds: a gyro at 16 Hz shows less than 8 Hz and a run of 5 s one period; lags
from an integration step to more than a run, where they are an integral; delays as far as their Padé form goes."""
_TYPICAL_TORQUE = 5e-5
"""N·m, of the class of platforms whose typical sizes parameters state: that of a constant torque, `body_torque`."""
_REACH = 1e6
"""Largest coefficient over its typical size: far beyond where the motion runs away."""


@final
class Formula(Effect):
    """Torque = coefficients times formulas, along an axis or in a direction that is estimated."""

    def __init__(
        self,
        pattern: Pattern,
        *,
        typical_value: Array,
        moment: float = TYPICAL_INERTIA,
        start: Array | None = None,
        scan_count: int = 1,
        name: str = "",
    ) -> None:
        """Take a formula.

        Args:
            pattern: the formula.
            typical_value: root mean square of each of its laws in the runs, shape (laws,); coefficients are typically
                a constant torque's size over it.
            moment: mean moment of inertia of the platform, with which torques go, kg·m².
            start: values of its constants to search from; their typical ones where None.
            scan_count: number of start values among which that one was found.
            name: under which a library keeps it; `formula` without one.
        """
        self.pattern = pattern
        self.id = name or ID
        self.components = ("platform",) if name else (str(pattern),)
        self.parameters = tuple(_parameters(pattern, typical_value, moment))
        self.sentence = _escaped(
            f"An unmodelled torque {place_words(pattern)} follows {law_words(pattern)}. {cause_of(pattern)}"
        )
        self.confirm = separating_flight(pattern)
        units = any(law.units_needed for law in pattern.laws)
        self.recurs = all(law.recurs for law in pattern.laws)
        self.includes = () if self.recurs else ("contact",)
        torque = any(law.reads_torque for law in pattern.laws)
        self.flies = self.recurs and not torque
        self.needs: tuple[Channel, ...] = (
            *(("gimbal_angle",) if units else ()),
            *(("applied_torque",) if torque else ()),
        ) or ("any_actuator",)
        self._start, self._scan_count = start, scan_count

    @staticmethod
    def of_size(pattern: Pattern, *, sizes: Array, moment: float, start: Array, name: str) -> Formula:
        """Return a formula whose coefficients are typically of a size that was found.

        Args:
            pattern: the formula.
            sizes: of the coefficients of each law, shape (laws,), SI.
            moment: mean moment of inertia of the platform on which it was found, kg·m².
            start: values of its constants there.
            name: under which the library keeps it.
        """
        value = _TYPICAL_TORQUE * moment / TYPICAL_INERTIA / sizes
        return Formula(pattern, typical_value=value, moment=moment, start=start, name=name)

    @override
    def hooks(self, component: str) -> Hooks:
        return formula_hooks(self.pattern)

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        absent = np.array([each.absent for each in self.parameters])
        if self._start is not None:
            absent[: len(self._start)] = self._start
        return absent[None]

    @override
    def scan_count(self, component: str, grid: Grid) -> int:
        return self._scan_count

    @override
    def measured(self, component: str, quantities: Sequence[Quantity]) -> str:
        if len(quantities) != len(self.parameters):  # some of them no sample shows
            return self.described(component)
        values, stds = [each.value for each in quantities], [each.std for each in quantities]
        return f"{measured_words(self.pattern, values, stds)}. {cause_of(self.pattern)}"

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        """Return it as entries of [[truth.torque]], behind those that the scenario has.

        None where it happened once, or reads the torque of actuators, which a flown platform does not have.
        """
        if not self.flies:
            return Extension()
        present: list[dict[str, Any]] = [each.model_dump(exclude_unset=True) for each in scenario.truth.torque]
        return Extension(scenario={"truth": {"torque": [*present, *flown_entries(self.pattern, values)]}})


def flown_entries(pattern: Pattern, values: Array) -> list[dict[str, Any]]:
    """Return a formula with its values as tables of [[truth.torque]]."""
    entries = []
    for torque in pattern.torques(values):
        size = float(np.linalg.norm(torque.coefficient))
        axis = torque.coefficient / size if size > 0.0 else np.eye(3)[0]
        along: dict[str, Any] = {"axis": axis.tolist(), "coefficient": size}
        if pattern.placement in "xyz":
            along = {"axis": pattern.placement, "coefficient": float(torque.coefficient @ pattern.axes[0])}
        entries.append({"formula": str(torque.law), "frame": pattern.frame, **along})
    return entries


def _parameters(pattern: Pattern, typical_value: Array, moment: float) -> Iterator[Parameter]:
    yield from (CONSTANTS[name] for name in pattern.names)
    waves = [f"{law.factors[0].function}_" if len(pattern.laws) > 1 else "" for law in pattern.laws]
    axes = [f"{axis}_" for axis in "xyz"] if len(pattern.axes) > 1 else [""]
    for law, wave, value in zip(pattern.laws, waves, typical_value, strict=True):
        unit = law.coefficient_unit
        for axis in axes:
            parameter = Parameter(name=f"coefficient_{wave}{axis}{unit.suffix}", unit=str(unit), typical=1.0)
            # What goes with the platform by its unit is stated for the class of platforms, the rest for this one.
            share = moment / TYPICAL_INERTIA / parameter.typical_on(moment)
            typical = float(_TYPICAL_TORQUE * share / value)
            yield Parameter(
                name=parameter.name,
                unit=parameter.unit,
                typical=typical,
                lower=-_REACH * typical,
                upper=_REACH * typical,
            )


def _escaped(text: str) -> str:
    """Return a text that `str.format` leaves as it is."""
    return text.replace("{", "{{").replace("}", "}}")
