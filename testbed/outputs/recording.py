"""What a run's recording shows besides the flight's channels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from math import inf

import numpy as np

from testbed.arrays import Series
from testbed.cmg.singularity import sphere_directions
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.dynamics.inertia_unit import InertiaUnit, inertia_unit
from testbed.experiment.experiment import Estimation, Experiment
from testbed.experiment.flying import flight_limits
from testbed.recording.content import (
    RecordingContent,
    ShownEstimate,
    ShownEvent,
    ShownLimits,
    ShownResidual,
)
from testbed.signals import KINDS

_ENVELOPE_DIRECTIONS = 400
"""Directions in which the momentum envelope is looked at; its support is then met to 0.2 %."""


def recording_content(experiment: Experiment, provenance: Mapping[str, str]) -> RecordingContent:
    """Return limits, estimates, residuals, events and text pages of a run."""
    estimation = experiment.estimation
    return RecordingContent(
        limits=_limits(experiment),
        nominal_theta=theta_of(experiment.nominal.inertia),
        true_theta=theta_of(experiment.truth.inertia),
        estimates=() if estimation is None else tuple(_estimates(estimation)),
        bound_std=None if estimation is None else estimation.bound_std,
        residuals=() if estimation is None else tuple(_residuals(estimation)),
        envelope_fraction=_envelope_fraction(experiment),
        events=tuple(_events(experiment)),
        result=_result_text(experiment),
        provenance=_table(("", ""), [(f"**{name}**", f"`{value}`") for name, value in provenance.items()]),
        properties={"seed": experiment.seed, "scenario": experiment.scenario.name, "outcome": experiment.outcome},
    )


def _limits(experiment: Experiment) -> ShownLimits:
    """Return the limits of each kind of actuator, of the weakest one, then those about the body axes."""
    limits, both = flight_limits(experiment.scenario), np.array([1.0, -1.0])
    rotors = experiment.scenario.gyros.rotor_momentum_limit / experiment.truth.cluster.rotor_spin_inertia
    levels = {name: np.min(limit, initial=inf) * both for name, limit in limits.items()}
    levels["rotor_speed"] = np.array([np.min(rotors, initial=inf)])
    of_kinds = {name: levels[name] for kind in KINDS.values() for name in kind.plots if name in levels}
    about_axes = {name: np.kron(both, limits[name]) for name in ("cluster_momentum", "cluster_torque")}
    return of_kinds | about_axes


def _estimates(estimation: Estimation) -> Iterator[ShownEstimate]:
    for name, estimate in estimation.by_name.items():
        yield ShownEstimate(name=name, theta=estimate.theta, std=estimate.std)


def _residuals(estimation: Estimation) -> Iterator[ShownResidual]:
    for name, estimate in estimation.by_name.items():
        yield ShownResidual(
            name=name, unit=estimate.residual_unit, time=estimate.residual_time, values=estimate.residual
        )


def _envelope_fraction(experiment: Experiment) -> Series:
    momentum_B, truth = experiment.flown.record.channels["true_cluster_momentum"], experiment.truth
    return truth.envelope_share(momentum_B, sphere_directions(_ENVELOPE_DIRECTIONS))


def _events(experiment: Experiment) -> Iterator[ShownEvent]:
    if experiment.flown.divergence:
        yield ShownEvent(time=float(experiment.flown.record.time[-1]), text=experiment.flown.divergence)


def _result_text(experiment: Experiment) -> str:
    summary = experiment.flown.summary
    measure = summary.min_singularity_measure
    lines = [
        f"# {experiment.scenario.name}",
        experiment.scenario.description,
        f"Outcome: **{experiment.outcome}**. {experiment.flown.divergence}",
        f"## Inertia, {_unit(experiment).text}",
        _estimate_table(experiment),
        "## Flight",
        f"- tracking error, rms: {_listed(summary.tracking_rms)} rad/s",
        f"- time at a limit: {summary.saturated:.3g} s",
        *([] if measure is None else [f"- smallest singularity measure: {measure:.3f}"]),
        f"- momentum drift: {summary.momentum_drift:.1e}",
    ]
    return "\n\n".join(lines[:6]) + "\n\n" + "\n".join(lines[6:])


def _estimate_table(experiment: Experiment) -> str:
    shown = partial(_shown, _unit(experiment))
    rows = [
        ("true", *shown(theta_of(experiment.truth.inertia))),
        ("nominal", *shown(theta_of(experiment.nominal.inertia))),
    ]
    if experiment.estimation is not None:
        for name, estimate in experiment.estimation.by_name.items():
            values = zip(shown(estimate.theta), shown(estimate.std), strict=True)
            rows.append((name, *(f"{value} ± {std}" for value, std in values)))
        if experiment.estimation.bound_std is not None:
            rows.append(("bound", *(f"± {value}" for value in shown(experiment.estimation.bound_std))))
    return _table(("", *PARAMETER_NAMES), rows)


def _table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _unit(experiment: Experiment) -> InertiaUnit:
    return inertia_unit(theta_of(experiment.truth.inertia))


def _shown(unit: InertiaUnit, values: Series) -> list[str]:
    return [unit.shown(value, 4) for value in values]


def _listed(values: Series) -> str:
    return ", ".join(f"{value:.2g}" for value in np.asarray(values))
