"""From records to the runs of a diagnosis: the gate that they pass, and their noise."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Matrix3, Theta
from testbed.assembly.platform import Body
from testbed.diagnosis.actuator_telemetry import unknown_between, where_known, with_telemetry_noise
from testbed.diagnosis.belief import Belief
from testbed.diagnosis.channels import too_exact_torques
from testbed.diagnosis.control_loop import shows_the_loop, with_mean_thrust
from testbed.diagnosis.copies import Flights
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted, nominal_fit, starts_of
from testbed.diagnosis.gate import Gate, require_motion, require_si, require_this_platform
from testbed.diagnosis.held_motors import along_chords
from testbed.diagnosis.held_torques import HELD, are_held, may_be_held
from testbed.diagnosis.measurement_notices import notices_of
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.noise_level import pooled_noise, with_pooled_noise
from testbed.diagnosis.reference import Reference
from testbed.diagnosis.roles import by_role
from testbed.diagnosis.run_starts import with_history
from testbed.diagnosis.settings import SETTINGS, PriorOdds
from testbed.diagnosis.spikes import without_spikes
from testbed.diagnosis.tachometers import least_scattered
from testbed.diagnosis.torque_knowledge import require_known_torque
from testbed.diagnosis.windows import Part, outliers_notice, parts_of
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.estimation.body import is_body
from testbed.estimation.surroundings import EXACT
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.command_phase import with_command_phase
from testbed.records.notices import grouped
from testbed.records.record import Record
from testbed.scenario.body import BodyScenario

Usable: TypeAlias = list[tuple[Record, tuple[Part, ...]]]
"""Records with the parts of them that can be predicted."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gated:
    """Records that have passed the gate.

    Attributes:
        usable: these, with the parts of them that can be predicted.
        refused: why others cannot be used.
        notices: what a reader has to know of a record, by its name.
        together: all parts as runs.
        baseline: the nominal model fitted to them.
        doubts: what was let through in spite of a doubt.
    """

    usable: Usable
    refused: tuple[str, ...]
    notices: tuple[tuple[str, str], ...]
    together: Runs
    baseline: Fit
    doubts: tuple[str, ...]

    @property
    def belief(self) -> Belief | None:
        """What is known of the parameters a priori."""
        return self.together.belief


def gated(records: Sequence[Record], scenario: BodyScenario, nominal: Body, *, at_rest: bool = False) -> Gated:
    """Return the records that may be of the scenario's platform; refuse them if none is.

    Args:
        records: measured.
        scenario: the gyro's noise where neither a record states it nor its samples tell it.
        nominal: geometry of the units, and the nominal inertia.
        at_rest: whether platforms that hardly turn may pass, because what follows asks by itself what the motion tells.

    Raises:
        InputError: no record can be used, the records' channels differ, or they are of another platform or in other
            units, or hardly turn.
    """
    if scenario.diagnosis.applied_torque is not None:
        return _gated(records, scenario, nominal, at_rest=at_rest)
    joined = _gated(records, sent_as(scenario, "sampled"), nominal, at_rest=at_rest)
    if not may_be_held(joined.together, joined.baseline):
        return joined
    try:
        held = _gated(records, sent_as(scenario, "held"), nominal, at_rest=at_rest)
    except InputError:  # what does not pass the gate so is not held
        return joined
    if not are_held(joined.together, joined.baseline, held.together, held.baseline):
        return joined
    return replace(held, doubts=(*held.doubts, HELD))


def sent_as(scenario: BodyScenario, applied_torque: Literal["sampled", "held"]) -> BodyScenario:
    """Return a scenario that says what a sample of an applied torque is."""
    stated = scenario.diagnosis.model_copy(update={"applied_torque": applied_torque})
    return scenario.model_copy(update={"diagnosis": stated})


def _gated(records: Sequence[Record], scenario: BodyScenario, nominal: Body, *, at_rest: bool) -> Gated:
    usable: Usable = []
    refused: list[str] = []
    notices: list[tuple[str, str]] = []
    flights = Flights()
    for record in records:
        own: list[tuple[str, str]] = []
        try:
            parts = tuple(parts_of(record, scenario, nominal, own))
            flights.add(record)
        except InputError as error:
            refused.append(str(error))
        else:
            usable.append((record, parts))
            notices += own
    if not usable:
        raise InputError("\n".join(refused))
    usable = _with_open_starts(_in_phase(usable))
    if scenario.diagnosis.horizon_s is None:  # windows have it
        usable = _with_telemetry(usable, with_history(_telemetry(usable)))
    together = runs_together(usable, range(len(usable)))
    if too_exact_torques(together.grid):
        usable = _without_torques(usable)
        notices += [(record.details.name, TOO_EXACT) for record, _ in usable]
        together = runs_together(usable, range(len(usable)))
    theta, gate = theta_of(nominal.inertia), Gate(accepted=scenario.diagnosis.accept)
    together = replace(together, belief=belief_of(together, scenario, theta))
    if not at_rest:
        require_motion(together, gate)
    require_si(together, theta, gate)
    # Where torque is known in part no inertia is refused, and a sample's spike stands out of any motion.
    baseline = nominal_fit(together, theta) if together.known_in_part else fitted(together, [], theta, [])
    require_this_platform(together, baseline, theta, gate)
    require_known_torque(together, baseline, gate)
    cleaner = least_scattered(baseline, _telemetry(usable))
    if cleaner is not None:
        usable = _with_telemetry(usable, cleaner)
        together = _together(usable, together)
        baseline = fitted(together, [], theta, [])
    return Gated(
        usable=usable,
        refused=tuple(refused),
        notices=tuple(notices),
        together=together,
        baseline=baseline,
        doubts=tuple(gate.notices),
    )


def _telemetry(usable: Usable) -> list[Telemetry]:
    return [part.telemetry for _, parts in usable for part in parts]


def _with_telemetry(usable: Usable, telemetry: Iterable[Telemetry]) -> Usable:
    found = iter(telemetry)
    return [(record, tuple(replace(part, telemetry=next(found)) for part in parts)) for record, parts in usable]


def _together(usable: Usable, like: Runs) -> Runs:
    """Return all parts side by side, with the belief of others."""
    return replace(runs_together(usable, range(len(usable))), belief=like.belief)


_KNOWN = 1e-4
"""Relative standard deviation of an inertia that is known: less than any record shows, more than rounding."""


def belief_of(runs: Runs, scenario: BodyScenario, theta: Theta) -> Belief | None:
    """Return what is known of a platform's parameters a priori; None where runs of gimbals or momentum decide alone.

    Only where torque is applied, known in part, does a fit need to hear that the nominal inertia is about right: the
    momentum that actuators store is known to per cents. A scenario that states an uncertainty is taken at its word.

    Args:
        runs: of the platform.
        scenario: with what it states of the inertia's uncertainty.
        theta: of the nominal model, shape (6,), kg·m².
    """
    platform = scenario.platform
    stated = _KNOWN if platform.inertia == "known" else platform.inertia_uncertainty
    if stated is None and runs.known_in_part:
        stated = _KNOWN  # only its ratio to the torque per command shows, which has a scale of its own about each axis
    if stated is None and not runs.trimmed:
        return None
    std = SETTINGS.inertia_uncertainty if stated is None else stated
    return Belief(
        nominal_theta=theta,
        log_ratio=np.zeros(6),
        log_ratio_std=std,
        reach=SETTINGS.inertia_reach * std,
        trim=np.zeros(3),
        trim_std=np.full(3, np.inf),
        effects=tuple(
            (each.key, np.zeros(each.size), np.full(each.size, SETTINGS.torque_scale_uncertainty))
            for each in _given(runs)
        ),
    )


def _with_open_products(runs: Runs, theta: Theta) -> Runs:
    """Return windows whose inertia is nearly as stated, rather than just so, if their commands explain the motion.

    Where they do not, records show what a controller makes of draughts, and of that no inertia can be learned.
    """
    given = _given(runs)
    try:
        fit = fitted(runs, given, theta, starts_of(runs, given))
    except InputError:  # the motion runs away
        return runs
    if runs.belief is None or shows_the_loop(runs, fit):
        return runs
    std = SETTINGS.window_inertia_uncertainty
    return replace(runs, belief=replace(runs.belief, log_ratio_std=std, reach=SETTINGS.inertia_reach * std))


def _given(runs: Runs) -> tuple[Hypothesis, ...]:
    """Return the effects that every model of runs has: over windows, torque per command is known in part."""
    if not runs.known_in_part:
        return ()
    return (Hypothesis(effect=EFFECTS["actuator_gain"], component="actuators", given=True),)


def runs_together(usable: Usable, chosen: Sequence[int], like: Runs | None = None) -> Runs:
    """Return the parts of some records as runs; like others of the platform, as `runs_of` takes them."""
    parts = [part for index in chosen for part in usable[index][1]]
    runs = runs_of([part.name for part in parts], [part.telemetry for part in parts], like)
    return replace(runs, windowed=tuple(part.stretch for part in parts if part.stretch is not None))


def _enough(runs: Runs) -> Runs:
    """Return windows of half-known torque, evenly chosen of many and with fewer samples; all others as they are.

    What turns the platform beside the known torque decides what they show, and that is slow: neighbouring samples, and
    neighbouring windows, say nearly the same.
    """
    if not runs.known_in_part:
        return runs
    count = len(runs.names)
    which = np.unique(np.linspace(0, count - 1, min(count, SETTINGS.most_windows)).round().astype(int)).tolist()
    fewer = runs_of([runs.names[index] for index in which], [_thinned(runs.grid.runs[index]) for index in which])
    return replace(fewer, windowed=tuple(runs.windowed[index] for index in which))


def _thinned(run: Telemetry) -> Telemetry:
    every = max(1, int(1.0 / (np.median(np.diff(run.gyro_time)) * SETTINGS.window_rate_hz)))
    return run.with_gyro_rows(slice(None, None, every))


@dataclass(frozen=True, kw_only=True, eq=False)
class DataSet:
    """What a folder of records gives the diagnosis.

    Attributes:
        runs: to fit.
        heldout: to verify on; None of a single run.
        fit_records: names of the records to fit.
        heldout_records: of those to verify on.
        notices: what a reader of the diagnosis has to know of the records.
        given: effects of the nominal model, of which `runs.belief` says what is known.
    """

    runs: Runs
    heldout: Runs | None
    fit_records: tuple[str, ...]
    heldout_records: tuple[str, ...]
    notices: tuple[str, ...]
    given: tuple[Hypothesis, ...] = ()

    def against(self, reference: Reference) -> DataSet:
        """Return the data with what healthy records of the platform show in the place of what is stated of it."""

        def known(runs: Runs, belief: Belief) -> Runs:
            runs = runs.with_sigma(reference.sigma)
            runs = with_mean_thrust(runs) if reference.belief.of_loop else runs
            return replace(runs, belief=belief, noise_freedom=reference.noise_freedom)

        return replace(
            self,
            runs=known(self.runs, reference.belief),
            heldout=None if self.heldout is None else known(self.heldout, reference.belief.of_records()),
            given=reference.given,
        )

    @property
    def alone(self) -> bool:
        """Whether there is but one record, in one part or several: what it shows can be verified on no other."""
        return len(self.fit_records) == 1 and not self.heldout_records


def data_set_of(
    records: Sequence[Record], scenario: BodyScenario, nominal: Body, fitted_records: Collection[str] = ()
) -> DataSet:
    """Return the runs to fit and those to hold out.

    Args:
        records: measured.
        scenario: the gyro's noise where neither a record states it nor its samples tell it.
        nominal: geometry of the units, and the nominal inertia.
        fitted_records: names of those that are fitted whatever is dealt.

    Raises:
        InputError: no record can be used, the runs' channels differ, or they are of another platform or in other units.
    """
    passed = gated(records, scenario, nominal)
    theta, notices = theta_of(nominal.inertia), list(passed.notices)
    usable = _in_orbit_as(passed.baseline.theta, _without_spikes(passed, notices))
    usable = _with_telemetry(usable, along_chords(_telemetry(usable), passed.baseline.theta))
    usable = _where_known(usable, passed.baseline.theta, notices)
    level = None
    if not all(_states_noise(record) for record, _ in usable):
        level = pooled_noise(_together(usable, passed.together), theta)
    used = [(record, [part.telemetry for part in parts]) for record, parts in usable]
    fit, heldout = by_role(used, fitted_records)

    stated = scenario.diagnosis
    prior_odds = PriorOdds.stated(stated.null_prior_odds, stated.unmodelled_prior_odds)

    def of(chosen: Sequence[int], belief: Belief | None, like: Runs | None = None) -> Runs:
        runs = replace(_enough(runs_together(usable, chosen, like)), belief=belief, prior_odds=prior_odds)
        if level is not None:
            return with_pooled_noise(runs, level)
        runs = replace(runs, noise_uncertainty=scenario.gyro.noise_uncertainty)
        return with_telemetry_noise(runs, passed.baseline.theta)

    runs = of(fit, passed.belief)
    if runs.known_in_part and scenario.platform.inertia_uncertainty is None and scenario.platform.inertia != "known":
        runs = _with_open_products(runs, theta)
    belief = runs.belief
    return DataSet(
        runs=runs,
        heldout=of(heldout, belief and belief.of_records(), runs) if heldout else None,
        fit_records=tuple(usable[index][0].details.name for index in fit),
        heldout_records=tuple(usable[index][0].details.name for index in heldout),
        notices=(
            *(f"left out: {reason}" for reason in passed.refused),
            *grouped(notices),
            *passed.doubts,
            *notices_of(passed.together),
        ),
        given=_given(passed.together),
    )


def _in_orbit_as(theta: Theta, usable: Usable) -> Usable:
    """Return the parts with the inertia that records show where a gravity gradient's torque is taken of a known one.

    Moments may differ by half as much again as the nominal ones do: the gradient came out a quarter too weak. What is
    no inertia of a body, as missing effects may make it, is not taken.
    """
    if not is_body(theta):
        return usable
    return _with_telemetry(usable, [_with_inertia(run, inertia_of(theta)) for run in _telemetry(usable)])


def _with_inertia(run: Telemetry, inertia: Matrix3) -> Telemetry:
    if run.surroundings is None or run.pivot is not None:
        return run
    return replace(run, surroundings=replace(run.surroundings, inertia=inertia))


def _in_phase(usable: Usable) -> Usable:
    """Return the parts with what the wheels' impulses show of when their commands change."""
    return _with_telemetry(usable, with_command_phase(_telemetry(usable)))


def _with_open_starts(usable: Usable) -> Usable:
    """Return the parts with the first attitude of all runs open, if that of any is: they have the same parameters."""
    runs = _telemetry(usable)
    around = [run.surroundings for run in runs]
    if not any(each is not None and each.start_std for each in around):
        return usable
    opened = [each and replace(each, start_std=max(each.start_std, EXACT)) for each in around]
    return _with_telemetry(usable, [replace(run, surroundings=each) for run, each in zip(runs, opened, strict=True)])


TOO_EXACT = (
    "gimbal_torque has less noise than its prediction resolves, and is not compared; where it is simulated, give it "
    "the noise of hardware to test what is inside the gimbals"
)


def _without_torques(usable: Usable) -> Usable:
    """Return the parts without the torques of the gimbals' motors."""
    return _with_telemetry(usable, map(_without_torque, _telemetry(usable)))


def _without_torque(run: Telemetry) -> Telemetry:
    return replace(run, gimbals=None if run.gimbals is None else replace(run.gimbals, torque=None))


def _without_spikes(passed: Gated, notices: list[tuple[str, str]]) -> Usable:
    """Return the parts less the gyro's outliers; of which records, is added to the notices."""
    cleaned = iter(zip(*without_spikes(passed.together, passed.baseline), strict=True))
    kept: Usable = []
    for record, parts in passed.usable:
        own = [next(cleaned) for _ in parts]
        kept.append((record, tuple(replace(part, telemetry=run) for part, (run, _) in zip(parts, own, strict=True))))
        if found := sum(count for _, count in own):
            samples = sum(len(part.telemetry.gyro_time) for part in parts)
            notices.append((record.details.name, outliers_notice(found, samples)))
    return kept


def _where_known(usable: Usable, theta: Theta, notices: list[tuple[str, str]]) -> Usable:
    """Return the parts less the gyro's samples between those of slow actuators; of which records, is added."""
    kept = _with_telemetry(usable, where_known(_telemetry(usable), theta))
    for (record, sent), (_, compared) in zip(usable, kept, strict=True):
        before, after = (sum(len(part.telemetry.gyro_time) for part in parts) for parts in (sent, compared))
        if after < before:
            notices.append((record.details.name, unknown_between(before - after, before)))
    return kept


def _states_noise(record: Record) -> bool:
    return bool(record.details.gyro_noise) or record.details.source == "simulated"
