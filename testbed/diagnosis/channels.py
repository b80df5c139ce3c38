"""What is compared beside the gyro: motor torques, servo responses, impulses of wheels, and in what noise each is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from testbed.arrays import Array, Flags, Series, Units
from testbed.diagnosis.settings import SETTINGS
from testbed.effects.fast_changes import FEWEST, fast_power
from testbed.estimation.noise_color import NoiseColor
from testbed.estimation.noise_spectrum import SpectrumPrior, noise_spectrum
from testbed.prediction.compared import torques_compared
from testbed.prediction.grid import Grid, unit_count
from testbed.prediction.impulse_noise import IMPULSE_UNKNOWNS, ImpulseFit, impulse_fit, wheels_with
from testbed.prediction.motor_torques import has_torques, measured_torques, unexplained_torques
from testbed.prediction.servo import response, ticks_of
from testbed.prediction.servo_response import by_stretches, by_units, constants, has_commands, measured_responses, shown
from testbed.prediction.smoothed import KNOTS_PER_SECOND, direction_of
from testbed.prediction.wheel_impulses import ImpulseNoise
from testbed.prediction.wheel_response import all_impulses, measured_impulses

_LEAST = 1e-3
"""Share of a channel's own scatter that its noise has at least: the model of a gimbal is no better than that. Of 64
sets of the seeds 90817 and 90818 none needs it: motor torques have noise of 4 % and more of their scatter, responses of
30 %. It keeps channels without noise from an infinite weight."""
_RESOLVED = 0.025
"""Share of its scatter below which the noise of a motor torque is less than what its prediction resolves: that knows a
gimbal's motion by samples, and misses 0.008 of the scatter (simulated flights without torque noise of mixed, pyramid4
and an adopted platform; at jumps of the command up to 0.2). In units of less noise that had names: two zeros and a
misalignment of healthy gimbals. Of the sets above none is below 0.04."""
_NUDGES = np.array([1e-5, 1e-3, 1e-3])
"""Lag, s, viscous friction, 1/s, and dry friction, rad/s², over the inertia, by which derivatives are taken: a
thousandth of the usual sizes and less, so that differences have three correct digits and more; steps need one."""
_USUAL = np.array([0.01, 1.0, 10.0])
"""Sizes of the same, by which steps are scaled: of the order of what hardware of this class shows (20 ms, 12 1/s, 12
rad/s²). They scale steps; where the search ends does not depend on them."""
_FIRST = 0.1
"""Share of the usual sizes at which the search begins. From a lag that is guessed too long, a servo swings, and no step
finds back (case_0624 of seed 2026): so it begins below, and steps are bounded."""
_TRIALS = 20
"""Evaluations of the search at most. With 100 nothing changes, with 5 estimates move by 2e-4 standard errors (three
sets of seed 90817 with effects inside the units)."""
_CLOSE = 1e-2
"""Share of the squares that a further step has to gain: 0.5 % of the root that is compared with the noise. With 1e-4
or 1e-1, estimates move by 9e-4 standard errors at most, in the same sets."""
_MODEL = 2.5e-4
"""rad. Error of a predicted servo response from other causes than noise: commands between samples and the plan are not
known, and what is missed by that stays for several samples. Without it, lags and dry frictions of eight detectable
sizes miss the truth by 4 to 6 standard deviations where encoders are as good as 1e-4 rad. In three sets of seed 90817
the responses are the same without it and with twice as much, and estimates move by 0.3 and 0.1 standard errors."""
_FIRST_AXIS = np.array([True, False, False])
"""Of three that a noise spectrum has: every unit of every run is a series of its own, and all have one colour."""
_SURELY_COLORED = 3.0
"""Standard errors from which neighbouring samples of a torque's noise surely go along.

Source: convention: one white channel of 370 then has a colour, by which nothing is wrong but the time that whitening
takes."""
_TORQUE_PRIOR = SpectrumPrior(
    level=3.0,  # of a mean of two samples the fastest changes have a tenth of the variance
    deviation=SETTINGS.noise_uncertainty,
    correlation=SETTINGS.noise_correlation_std,
    correlation_deviation=SETTINGS.noise_correlation_axis_std,
    persistence=SETTINGS.noise_persistence_std,
    color=SETTINGS.noise_color_prior,
    slowest=0.5 * KNOTS_PER_SECOND,
    share_of_rate=SETTINGS.noise_share_of_rate,
    most_power=np.inf,
)
"""Of the noise of motor torques, whose level nobody states."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelNoise:
    """Noise of one channel of a run, K samples of W columns.

    Attributes:
        sigma: standard deviation of each column, shape (W,), in the channel's unit.
        color: how neighbouring samples go along; None where they are independent.
        time: of the samples, shape (K,), s; None where they are equidistant.
    """

    sigma: Array
    color: NoiseColor | None = None
    time: Series | None = None

    def whitened(self, values: Array) -> Array:
        """Return values in units of the noise and without its colour, shape (K, W) or (K, W, C)."""
        scaled = np.asarray(values / (self.sigma if values.ndim == 2 else self.sigma[:, None]))
        return scaled if self.color is None else self.color.decorrelated(scaled, self._time(scaled))

    def of_white(self, white: Array) -> Array:
        """Return what is white, shape (K, W), in the channel's unit and with the colour: the inverse of `whitened`."""
        return self.sigma * (white if self.color is None else self.color.correlated(white, self._time(white)))

    def _time(self, values: Array) -> Series:
        return np.arange(float(len(values))) if self.time is None else self.time


class Channel(NamedTuple):
    """One channel of every run.

    Attributes:
        measured: of every run, shape (K, W).
        noise: of every run.
    """

    measured: list[Array]
    noise: list[ChannelNoise]


def torque_channel(grid: Grid) -> Channel | None:
    """Return the measured motor torques of every run, each of shape (K, M), N·m; None without."""
    if not has_torques(grid):
        return None
    torques, times = measured_torques(grid), [run.actuator_time[torques_compared(run)] for run in grid.runs]
    sigma = _noise(torques)
    level, color = _torque_color(unexplained_torques(grid.gimbal_runs), times, sigma)
    return Channel(torques, [ChannelNoise(sigma=level * sigma, color=color, time=time) for time in times])


def too_exact_torques(grid: Grid) -> bool:
    """Return whether the motor torques have less noise than their prediction resolves, as simulated ones may have."""
    if not has_torques(grid):
        return False
    torques = measured_torques(grid)
    scatter = np.concatenate(torques).std(axis=0)
    return bool(np.median(_noise(torques) / np.maximum(scatter, np.finfo(float).tiny)) < _RESOLVED)


def _torque_color(residuals: Sequence[Array], times: Sequence[Series], sigma: Units) -> tuple[float, NoiseColor | None]:
    """Return the noise of the motor torques over that of its fastest changes, and its colour; (1, None) if it is white.

    Currents behind a filter, or interpolated, change less from sample to sample than they scatter. The residual of
    motion and friction is noise where it is faster than the smoothed motion can be.

    Args:
        residuals: of motion and friction in every run, shape (K, M), N·m.
        times: of their samples, shape (K,), s.
        sigma: of each unit's torque by its fastest changes, shape (M,), N·m.
    """
    long = [each for each in zip(residuals, times, strict=True) if len(each[1]) >= FEWEST]
    series = [(unit[:, None] * _FIRST_AXIS, time) for residual, time in long for unit in (residual / sigma).T]
    if not series:
        return 1.0, None
    whitened, own_times = zip(*series, strict=True)
    spectrum = noise_spectrum(whitened, own_times, _TORQUE_PRIOR, np.tile(_FIRST_AXIS, (len(series), 1)))
    if spectrum is None or abs(spectrum.correlation) < _SURELY_COLORED * spectrum.correlation_std:
        return 1.0, None
    level = np.sqrt(spectrum.variance_ratio[:, 0].mean())
    color, like = spectrum.color, np.ones(len(sigma))
    return float(level), NoiseColor(persistence=color.persistence[0] * like, average=color.average[0] * like)


def response_channel(grid: Grid) -> Channel | None:
    """Return what is compared of every run's gimbal angles, each of shape (K, M - 3), rad.

    None where commands are not sent, or the gimbals do not follow them as their servo would.
    """
    if not has_commands(grid):
        return None
    responses = measured_responses(grid)
    if not any(len(each) for each in responses):
        return None
    left = _left(grid, responses)
    pairs = zip(grid.commanded_runs, left, strict=True)
    by_unit = [part for run, each in pairs for part in by_stretches(run, by_units(run, each))]
    units, directions = unit_count(grid), responses[0].shape[1]
    noise = np.sqrt(units / directions * np.mean(_noise(by_unit) ** 2))  # M columns hold the noise of M - 3 directions
    unknowns = len(_NUDGES) * units + sum(constants(run).shape[1] for run in grid.commanded_runs)
    squares = np.concatenate(left).ravel() ** 2
    if len(squares) < SETTINGS.servo_numbers_per_unknown * unknowns:
        return None
    missed = np.sqrt(squares.sum() / (len(squares) - unknowns))
    if missed >= SETTINGS.servo_following * noise:
        return None
    sigma = np.full(directions, np.hypot(max(missed, noise), _MODEL))
    return Channel(responses, [ChannelNoise(sigma=sigma)] * len(responses))


def impulse_channels(grid: Grid) -> list[Channel]:
    """Return the impulses of the motor of every wheel that is compared, each of shape (K, 1), N·m·s."""
    if grid.wheel_noise is None:
        return []
    wheels = zip(measured_impulses(grid), grid.wheel_noise.sigma[:, None], strict=True)
    return [Channel(blocks, [ChannelNoise(sigma=sigma)] * len(blocks)) for blocks, sigma in wheels]


def wheel_channel(grid: Grid) -> ImpulseNoise | None:
    """Return in what noise the wheels' motors are compared with what turns the wheels; None where they are not.

    By their commands where these are sent and every wheel that is compared follows its own, or else by their measured
    torques. A wheel that stands still, or of which there are too few impulses, is left out; the others stay.
    """
    fits = _impulse_fits(grid)
    return next((fit.noise for fit in fits if not _unfollowed(fit).any()), None)


def unfollowed(grid: Grid) -> dict[str, Array]:
    """Return, by channel, how many times what it says wheels gain that do not follow it, shape (W,).

    The measured torque too where the command is compared: nobody looks at it then, and a wrong unit stays.
    """
    fits = ((fit, _unfollowed(fit)) for fit in _impulse_fits(grid))
    return {_CHANNELS[fit.noise.commanded]: fit.factor[wheels] for fit, wheels in fits if wheels.any()}


_CHANNELS = {True: "wheel_torque_command", False: "wheel_torque"}


def _impulse_fits(grid: Grid) -> Iterator[ImpulseFit]:
    """Yield how wheels follow their commands, and then their measured torques, where enough impulses are known."""
    for commanded in (True, False):
        impulses = all_impulses(grid, commanded=commanded)
        wheels = wheels_with(impulses, SETTINGS.wheel_numbers_per_unknown * IMPULSE_UNKNOWNS)
        if wheels:
            yield impulse_fit(impulses, wheels, commanded=commanded)


def _unfollowed(fit: ImpulseFit) -> Flags:
    """Return which of the wheels that are compared surely gain something else than they were asked for, shape (C,)."""
    beyond = np.abs(np.log(np.maximum(fit.factor, np.finfo(float).tiny))) > np.log(SETTINGS.wheel_following)
    return np.asarray(beyond & (np.abs(fit.factor - 1.0) > _SURELY * fit.factor_std))


_SURELY = 5.0
"""Standard errors by which a wheel's torque has to differ from what it is commanded to count as another one's: of a
wheel that hardly moves it is not known, and says nothing."""


def _left(grid: Grid, responses: Sequence[Array]) -> list[Array]:
    """Return what every run's gimbals miss of the response of servos with a lag and friction each, (K, M - 3), rad."""
    nudges, usual = (np.repeat(each, unit_count(grid)) for each in (_NUDGES, _USUAL))

    def left(unknowns: Array) -> Array:
        return np.concatenate([part[0].ravel() for part in _missed(grid, responses, unknowns[None])])

    def slopes(unknowns: Array) -> Array:
        parts = _missed(grid, responses, np.vstack([unknowns, unknowns + np.diag(nudges)]))
        changes = np.concatenate([(part[1:] - part[:1]).reshape(len(nudges), -1) for part in parts], axis=1)
        return np.asarray(changes.T / nudges)

    found = scipy.optimize.least_squares(
        left,
        _FIRST * usual,
        slopes,
        bounds=(0.0, np.inf),
        x_scale=usual,
        ftol=_CLOSE,
        max_nfev=_TRIALS,
    )
    edges = np.cumsum([each.size for each in responses])[:-1]
    return [part.reshape(each.shape) for part, each in zip(np.split(found.fun, edges), responses, strict=True)]


def _missed(grid: Grid, responses: Sequence[Array], unknowns: Array) -> list[Array]:
    """Return measured less predicted responses of servos with lag, viscous and dry friction, (P, K, M - 3), rad."""
    lag, viscous, dry = np.split(unknowns, 3, axis=1)
    parts = []
    for run, measured in zip(grid.commanded_runs, responses, strict=True):
        rate = ticks_of(run).gimbal_rate
        against = viscous[:, None] * rate + dry[:, None] * direction_of(rate)
        parts.append(measured - shown(run, response(run, lag, against)))
    return parts


def _noise(channel: Sequence[Array]) -> Units:
    """Return the standard deviation of every column's noise, shape (W,), of all runs together.

    Args:
        channel: of every run, shape (K, W).
    """
    least = _LEAST * np.concatenate(channel).std(axis=0) + np.finfo(float).tiny
    long = [each for each in channel if len(each) >= FEWEST]
    if not long:
        return np.asarray(np.concatenate(channel).std(axis=0) + least)
    return np.asarray(np.maximum(np.sqrt(np.mean(np.concatenate([fast_power(each) for each in long]), axis=0)), least))
