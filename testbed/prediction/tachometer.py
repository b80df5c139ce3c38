"""What wheels hold behind the noise of their tachometers.

A wheel's momentum is what its motor adds up. What samples differ by from the impulses that were commanded is modelled
as an integrated Wiener process, of intensity q (torques that were not foreseen change smoothly), plus a Wiener process,
of intensity r (they jitter), plus white noise of variance s². All three follow from the samples by restricted maximum
likelihood, so that what jitters is not smoothed away. With divided second differences Qᵀy of samples, which no line
changes, their covariance is K = q R + r W + s² QᵀQ, R and W tridiagonal, and the posterior mean is y - s² Q K⁻¹ Qᵀ y.
Where no torque is known, turns that a maneuver asked for are no random walk: the intensities come out too large, by ten
and more, and noise may be found that is none. There samples are smoothed by several smaller intensities, never by more
than the noise that was found, and it is for the gyro to choose: see `smoothed_wheels`, and `smoothed_rotors` for the
rotors of control moment gyros.

Left as they are, the tachometers' errors stand in the predicted body rate as J⁻¹ δh, and a model in which the body does
not follow its wheels' fast motion explains samples better than the true one: light platforms seemed to have a flexible
appendage.

Sources: Reinsch, "Smoothing by spline functions", Numerische Mathematik (1967); Wahba, "A comparison of GCV and GML for
choosing the smoothing parameter in the generalized spline smoothing problem", Annals of Statistics (1985).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs
from scipy.optimize import minimize, minimize_scalar

from testbed.arrays import Array, Flags, Series, Units, UnitSeries
from testbed.estimation.gaps import between_gaps
from testbed.estimation.telemetry import CommandedGimbals, SmoothedMomentum, Telemetry
from testbed.estimation.telemetry_noise import fast_variance
from testbed.prediction.wheel_impulses import Impulses, impulses_of

_FEWEST = 20
"""Samples of all runs from which three variances are estimated; of fewer the tachometers are taken as they are."""
_RANGE = 25.0
"""Largest natural logarithm of an intensity over the noise's variance, times counted in the usual interval: beyond it
the noise is rounding."""
_NO_NOISE = 30.0
"""The same where there is none; far above the range, so that one of the two ratios is large whatever they share."""
_SURELY = 9.0
"""By which twice the log-likelihood has to fall without any noise: three standard errors. Of torques that jitter a
fifth may pass for noise by chance, and would be taken away."""
_STARTS = ((-4.0, -12.0), (-12.0, -2.0), (6.0, 0.0))
"""Logarithms of q and r over s² from which the search begins: torques that change smoothly, torques that jitter, and
hardly any noise."""
_SIMPLEX = ((0.0, 0.0), (3.0, 0.0), (0.0, 3.0))
"""Around each of them: by its corners, factors of twenty, it walks."""
_ENDS = 2
"""Samples of a piece that have no second difference of their own."""
_ENOUGH = 1e-2
"""Of the logarithms and of twice the log-likelihood, to which the search goes: a hundredth of what one standard error
of a variance costs."""
_STIFFER = tuple(10.0 ** (-half / 2.0) for half in range(7))
"""Shares of the intensities with which samples are smoothed where no torque is known: of a satellite of 60 kg with
three wheels and noise of 0.1 or 0.29 rad/s, a tenth to a thirtieth predicts the gyro best."""
_SHARE = 1e-4
"""Step of a central difference: its error is the square of it, a millionth of a percent."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Bands:
    """Lower bands, shapes (3, n), of what adds up to the covariance of a run's second differences, and Q.

    Attributes:
        smooth: R, of torques that change smoothly.
        jitter: W, of torques that jitter.
        noise: QᵀQ.
        weights: of three neighbouring samples in each difference, shape (n, 3).
    """

    smooth: Array
    jitter: Array
    noise: Array
    weights: Array

    def covariance(self, ratios: Array) -> Array:
        """Return the bands of K/s², of q/s² and r/s²."""
        smooth, jitter = ratios
        return np.asarray(smooth * self.smooth + jitter * self.jitter + self.noise)

    def differences(self, samples: Series) -> Series:
        """Return Qᵀy of samples, shape (n + 2,), shape (n,)."""
        first, second, third = self.weights.T
        return np.asarray(first * samples[:-2] + second * samples[1:-1] + third * samples[2:])

    def spread(self, differences: Series) -> Series:
        """Return Q z of one number for each difference, shape (n,), shape (n + 2,)."""
        whole = np.zeros(len(differences) + _ENDS)
        for place, weights in enumerate(self.weights.T):
            whole[place : place + len(differences)] += weights * differences
        return whole


def without_tachometer_noise(runs: Sequence[Telemetry]) -> list[Telemetry]:
    """Return runs whose wheels' momenta are known as well as speeds and torques together show.

    Args:
        runs: of one platform, whose tachometers are equally good in all; what was smoothed before stays.
    """
    sent = [run.wheels for run in runs if run.wheels is not None]
    commanded = [given for given in map(_commanded, runs) if given is not None]
    done = all(each.smoothed is not None for each in sent)
    if done or len(commanded) < len(runs) or sum(map(len, commanded)) < _FEWEST:
        return list(runs)
    pieces = _pieces([run.actuator_time for run in runs], list(map(_unknown, runs)))
    unforeseen = [each.momentum - known for each, known in zip(sent, commanded, strict=True)]
    return _with_errors(
        runs, [_removed(pieces, list(own)) for own in zip(*(each.T for each in unforeseen), strict=True)]
    )


def smoothed_wheels(runs: Sequence[Telemetry]) -> Iterator[list[Telemetry]]:
    """Yield runs with their wheels' momenta smoothed otherwise, for the gyro to choose; none where they are smoothed.

    Ever more where no torque is known, if noise is found. By known torques samples are smoothed as these have it, and
    the alternative is not to smooth them: of torques that change between their samples a part is not known, and the
    controller made it of the gyro's noise, by which errors of smoothing then seem to be the body's motion.

    Args:
        runs: of one platform, whose tachometers are equally good in all.
    """
    sent = [run.wheels for run in runs if run.wheels is not None]
    if len(sent) < len(runs) or any(each.smoothed is not None for each in sent):
        return
    known = [_impulses(run) is not None for run in runs]
    if any(known):
        if all(known):
            by_wheel = zip(*(each.momentum.T for each in sent), strict=True)
            yield _with_errors(runs, [_none_of(list(own)) for own in by_wheel])
        return
    samples, spin = [each.momentum for each in sent], sent[0].wheels.spin_inertia
    for errors, noise in _ever_stiffer([run.actuator_time for run in runs], samples, spin):
        yield _with_errors(runs, errors, noise * spin)


def smoothed_rotors(runs: Sequence[Telemetry]) -> Iterator[list[Telemetry]]:
    """Yield runs with the momenta of their gyros' rotors smoothed, ever more; none where no noise is found.

    Args:
        runs: of one platform, whose tachometers are equally good in all.
    """
    sent = [run.gimbals for run in runs if run.gimbals is not None]
    samples = [each.rotor_momentum for each in sent if each.rotor_momentum is not None]
    if len(samples) < len(runs):
        return
    spin = sent[0].cluster.rotor_spin_inertia
    for by_rotor, noise in _ever_stiffer([run.actuator_time for run in runs], samples, spin):
        yield [
            replace(run, gimbals=replace(gimbals, rotor_momentum=momentum - error, rotor_speed_noise=noise))
            for run, gimbals, momentum, error in zip(runs, sent, samples, _by_run(by_rotor), strict=True)
        ]


def smoothed_gimbals(runs: Sequence[Telemetry]) -> Iterator[list[Telemetry]]:
    """Yield runs with their gimbals' angles smoothed, ever more; none where no noise is found.

    Nor where motor torques or rate commands were sent: those are compared with the angles as the encoders gave them.

    Args:
        runs: of one platform, whose encoders are equally good in all.
    """
    sent = [run.gimbals for run in runs if run.gimbals is not None]
    if len(sent) < len(runs) or any(each.torque is not None or isinstance(each, CommandedGimbals) for each in sent):
        return
    angles = [np.unwrap(each.angle, axis=0) for each in sent]
    for by_gimbal, noise in _ever_stiffer([run.actuator_time for run in runs], angles, np.ones(angles[0].shape[1])):
        variance = np.array([each for _, each in by_gimbal])
        yield [
            replace(run, gimbals=replace(gimbals, angle=angle - error, angle_noise=noise, angle_variance=variance))
            for run, gimbals, angle, error in zip(runs, sent, angles, _by_run(by_gimbal), strict=True)
        ]


def _ever_stiffer(
    times: Sequence[Series], samples: Sequence[UnitSeries], spin: Units
) -> Iterator[tuple[list[tuple[list[Series], float]], float]]:
    """Yield what smoothing takes from each channel, ever more, as `_Noise.removed` has it, and the sensors' noise.

    Args:
        times: of every run's samples, shape (K,), s.
        samples: momenta, shape (K, W), N·m·s, or angles, rad.
        spin: of each channel what it has per unit of its sensor, shape (W,): inertia about the axis, kg·m², or one.
    """
    if sum(map(len, samples)) < _FEWEST:
        return
    bands = [_bands(time, float(np.median(np.diff(time)))) for time in times]
    wheels = [_Noise.of(bands, list(each)) for each in zip(*(own.T for own in samples), strict=True)]
    found = [each.variance / own**2 for each, own in zip(wheels, spin, strict=True) if each.ratios is not None]
    if not found:
        return
    worst = max(found)  # the tachometers of one array are alike
    alike = [each.with_variance(worst * own**2) for each, own in zip(wheels, spin, strict=True)]
    for share in _STIFFER:
        yield [each.removed(share) for each in alike], float(np.sqrt(worst))


def separated_noise(times: Sequence[Series], samples: Sequence[Series], broken: Sequence[Flags]) -> list[Series]:
    """Return the white noise in samples that change smoothly or jitter, of every run; zeros where none surely is.

    Args:
        times: of the samples, shape (K,), s.
        samples: of one channel in every run, shape (K,).
        broken: between which samples the channel jumps, shape (K - 1,).
    """
    if sum(map(len, samples)) < _FEWEST:
        return [np.zeros_like(each) for each in samples]
    return _removed(_pieces(times, broken), samples)[0]


class _Piece(NamedTuple):
    """Samples that follow on one another by what is modelled: of which run, which of them, and their bands."""

    run: int
    rows: slice
    bands: _Bands


def _pieces(times: Sequence[Series], broken: Sequence[Flags]) -> list[_Piece]:
    """Return the pieces of every run that are long enough for second differences.

    Args:
        times: of every run's samples, shape (K,), s.
        broken: between which of them something happens that is not modelled, shape (K - 1,).
    """
    return [
        _Piece(run, rows, _bands(time[rows], float(np.median(np.diff(time)))))
        for run, (time, each) in enumerate(zip(times, broken, strict=True))
        for rows in between_gaps(each)
        if rows.stop - rows.start > _ENDS
    ]


def _removed(pieces: Sequence[_Piece], samples: Sequence[Series]) -> tuple[list[Series], float]:
    """Return the noise in a channel's samples of every run, as `_Noise.removed`; none in what is no piece."""
    noise = _Noise.of([each.bands for each in pieces], [samples[each.run][each.rows] for each in pieces])
    errors, variance = noise.removed()
    whole = [np.zeros_like(each) for each in samples]
    for piece, own in zip(pieces, errors, strict=True):
        whole[piece.run][piece.rows] = own
    return whole, variance


def _with_errors(
    runs: Sequence[Telemetry], by_wheel: Sequence[tuple[list[Series], float]], noise: Units | None = None
) -> list[Telemetry]:
    """Return runs less errors in their wheels' samples.

    Args:
        runs: with wheels.
        by_wheel: of each its errors in every run, and the variance of what stays.
        noise: as `SmoothedMomentum` has it.
    """
    variance = np.array([variance for _, variance in by_wheel])
    found = []
    for run, error in zip(runs, _by_run(by_wheel), strict=True):
        assert run.wheels is not None
        best = SmoothedMomentum(samples=run.wheels.momentum - error, variance=variance, noise=noise)
        found.append(replace(run, wheels=replace(run.wheels, smoothed=best)))
    return found


def _by_run(by_wheel: Sequence[tuple[list[Series], float]]) -> list[UnitSeries]:
    """Return the errors in every run's samples, shape (K, W)."""
    return [np.stack(of_run, axis=-1) for of_run in zip(*(errors for errors, _ in by_wheel), strict=True)]


def _commanded(run: Telemetry) -> UnitSeries | None:
    """Return what wheels gained by their torques, less the known friction, shape (K, W), N·m·s; None if not known.

    Relative to the body, as tachometers count: a wheel that nothing turns falls behind a body that turns faster. Left
    to what is not foreseen, a seventh of that is smoothed away where the motion has corners, and the inertia comes out
    1e-4 too small.
    """
    impulses = _impulses(run)
    if impulses is None:
        return None
    gained = np.cumsum(impulses.asked - impulses.friction - impulses.carried, axis=0)
    return np.concatenate([np.zeros_like(gained[:1]), gained])


def _impulses(run: Telemetry) -> Impulses | None:
    """Return what the motors were asked for, or gave where no command was sent; None where neither is known."""
    return impulses_of(run, commanded=True) or impulses_of(run, commanded=False)


def _unknown(run: Telemetry) -> Flags:
    """Return between which samples nobody knows what the motors of some wheel gave, shape (K - 1,)."""
    impulses = _impulses(run)
    return np.zeros(len(run.actuator_time) - 1, dtype=np.bool_) if impulses is None else impulses.unknown


def _bands(time: Series, usual: float) -> _Bands:
    """Return the bands of samples, times counted in their usual interval, s."""
    step = np.diff(time) / usual
    before, after = 1.0 / step[:-1], 1.0 / step[1:]
    weights = np.stack([before, -before - after, after], axis=-1)
    smooth, jitter, noise = (np.zeros((3, len(before))) for _ in range(3))
    smooth[0], smooth[1, :-1] = (step[:-1] + step[1:]) / 3.0, step[1:-1] / 6.0
    jitter[0], jitter[1, :-1] = before + after, -after[:-1]
    for apart in range(3):
        products = weights[: len(before) - apart, apart:] * weights[apart:, : 3 - apart]
        noise[apart, : len(before) - apart] = products.sum(axis=1)
    return _Bands(smooth=smooth, jitter=jitter, noise=noise, weights=weights)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Noise:
    """What was found of the noise in a wheel's samples.

    Attributes:
        pairs: of each run its bands, and the second differences of its samples.
        ratios: q/s² and r/s²; None where the samples may as well be without noise.
        variance: s², (N·m·s)²; where there may be none, that of the fastest changes.
    """

    pairs: list[tuple[_Bands, Series]]
    ratios: Array | None
    variance: float

    @staticmethod
    def of(bands: Sequence[_Bands], samples: Sequence[Series]) -> _Noise:
        """Return what samples of all runs together show."""
        pairs = [(own, own.differences(each)) for own, each in zip(bands, samples, strict=True)]
        if not any(values.any() for _, values in pairs):  # a wheel that stands still, or holds one speed exactly
            return _Noise(pairs=pairs, ratios=None, variance=0.0)
        ratios = _likeliest_ratios(pairs)
        if ratios is None:
            return _Noise(pairs=pairs, ratios=None, variance=_fast_variance(samples))
        solved = [(values, _solved(own, ratios, values)) for own, values in pairs]
        squares = sum(float(values @ each) for values, each in solved)
        return _Noise(pairs=pairs, ratios=ratios, variance=squares / sum(len(values) for values, _ in solved))

    def with_variance(self, variance: float) -> _Noise:
        """Return the same torques behind more noise, (N·m·s)²; as it is where none was found."""
        if self.ratios is None:
            return self
        return replace(self, ratios=self.ratios * self.variance / variance, variance=variance)

    def removed(self, share: float = 1.0) -> tuple[list[Series], float]:
        """Return the noise in the samples, shapes (K,), N·m·s, and the variance of the error that stays, (N·m·s)².

        Args:
            share: of the intensities of the torques that were found; what is removed is no more than the noise.
        """
        if self.ratios is None:
            return [np.zeros(len(values) + _ENDS) for _, values in self.pairs], self.variance
        ratios = share * self.ratios
        errors = [own.spread(_solved(own, ratios, values)) for own, values in self.pairs]
        number = sum(map(len, errors))
        size = float(np.sqrt(sum(float(each @ each) for each in errors) / number / self.variance))
        taken = sum(_trace(own, ratios) for own, _ in self.pairs)
        return [each / max(size, 1.0) for each in errors], self.variance * (1.0 - taken / number)


def _solved(own: _Bands, ratios: Array, differences: Series) -> Series:
    return _solution(_factor(own.covariance(ratios)), differences)


def _factor(bands: Array) -> Array:
    """Return the lower bands of a covariance's Cholesky factor.

    LAPACK by its own names: a thousand covariances of a few hundred samples are tried, and SciPy's functions around it
    take four times as long as it does.
    """
    factor, failed = dpbtrf(bands, lower=1)
    if failed:
        raise np.linalg.LinAlgError("the covariance of the differences is not positive definite")
    return np.asarray(factor)


def _solution(factor: Array, differences: Series) -> Series:
    """Return K⁻¹ of differences, from the factor of K."""
    return np.asarray(dpbtrs(factor, differences, lower=1)[0])


def _none_of(samples: Sequence[Series]) -> tuple[list[Series], float]:
    """Return no errors in a wheel's samples, and the variance that then stays, as `_Noise.removed` has them."""
    return [np.zeros_like(each) for each in samples], _fast_variance(samples)


def _fast_variance(samples: Sequence[Series]) -> float:
    """Return the variance of the fastest changes of a channel in all runs."""
    of_runs = [len(each) * float(fast_variance(each[:, None])[0]) for each in samples]
    return sum(of_runs) / sum(map(len, samples))


def _likeliest_ratios(pairs: Sequence[tuple[_Bands, Series]]) -> Array | None:
    """Return q/s² and r/s² of the samples of all runs together; None where they may as well be without noise."""
    without = minimize_scalar(
        lambda share: _minus_log_likelihood(np.array([share, -share]) + _NO_NOISE, pairs),
        bounds=(-_RANGE, _RANGE),
        method="bounded",
    )
    found = [
        minimize(
            _minus_log_likelihood,
            start,
            (pairs,),
            "Nelder-Mead",
            bounds=[(-_RANGE, _RANGE)] * 2,
            options={"initial_simplex": np.add(start, _SIMPLEX), "xatol": _ENOUGH, "fatol": _ENOUGH},
        )
        for start in _STARTS
    ]
    best = min(found, key=lambda each: float(each.fun))
    surely = float(without.fun) - float(best.fun) > _SURELY
    return np.asarray(np.exp(best.x)) if surely else None


def _minus_log_likelihood(logarithms: Array, pairs: Sequence[tuple[_Bands, Series]]) -> float:
    """Return minus twice the restricted log-likelihood, the noise's variance at its best, without constants."""
    squares, determinants, number = 0.0, 0.0, 0
    for own, values in pairs:
        factor = _factor(own.covariance(np.exp(logarithms)))
        squares += float(values @ _solution(factor, values))
        determinants += _log_determinant(factor)
        number += len(values)
    return number * float(np.log(squares / number)) + determinants


def _trace(own: _Bands, ratios: Array) -> float:
    """Return the trace of s² Q K⁻¹ Qᵀ: how log det K grows with the noise's share of it, by a central difference."""
    whole = own.covariance(ratios)
    above, below = (_log_determinant(_factor(whole + step * own.noise)) for step in (_SHARE, -_SHARE))
    return (above - below) / (2.0 * _SHARE)


def _log_determinant(factor: Array) -> float:
    return 2.0 * float(np.log(factor[0]).sum())
