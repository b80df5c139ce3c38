"""The evidence of effects: its integral against importance sampling, and whether its probabilities are calibrated.

`python -m benchmarks.evidence integral` takes the Bayes factor of 50 fitted effects (5 at most of each small blind set)
by Laplace's method, as the diagnosis does, and by importance sampling of the true prediction; both in the same prior.
The sets have the seeds from 13 on, every other one has an effect of two detectable sizes.

`python -m benchmarks.evidence calibration` diagnoses small blind sets, --null N without an effect and --single N with
one of typical size times a factor that the prior has, --seed S; one pool for every share of null sets, whose sets count
by the share, and whose probabilities are of the prior odds that the share stands for. What is there already is kept.
Every kind of effect is hidden as often; with --as-prior sets are drawn as the prior of the diagnosis has it: an effect
that each of six units may have six times as often as one of the platform, and of sizes that are normal about none.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count, islice
from pathlib import Path

import numpy as np
from scipy.special import logsumexp
from scipy.stats import multivariate_t

from benchmarks.blind_diagnosis import diagnose_case
from concealing.case import Case
from concealing.effect import HiddenEffect, scaled
from concealing.files import conceal
from concealing.library import LISTED
from concealing.nominal import DivergedError
from concealing.power import UnreachableError
from concealing.sealing import SEAL
from concealing.strata import NEVER_HIDDEN
from support.blind_cases import blind_case
from support.diagnosed_records import SCENARIO
from testbed.arrays import Array
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.candidates import BETWEEN, NONE, UNKNOWN, Candidate
from testbed.diagnosis.data import Runs
from testbed.diagnosis.method import baseline
from testbed.diagnosis.model import Fit, orthonormal, projected_out
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.screening import screened
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.size_prior import SizePrior
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.library.records import read_records
from testbed.library.scenarios import read_scenario
from testbed.prediction.prediction import predicted_channels
from testbed.scoring.case import Case as Scored
from testbed.scoring.case import read_cases
from testbed.scoring.judging import truths

SHARES = (0.05, 0.25, 0.5, 0.95)
"""Of null sets."""
WANTED = 0.05
"""Calibration error at most."""
SEED, NULL, SINGLE = 40, 60, 90
_HIDDEN = (("rotor_speed", "cmg3"), ("gyro_bias", "gyro"), ("body_torque", "platform"), ("gimbal_zero", "cmg2"))
_HIDDEN += (("gyro_latency", "gyro"),)
"""Effects of the first five sets of `integral` that have one."""
_COMPARED = 50
"""Bayes factors that are taken in both ways."""
_SAMPLES = 1500
"""Of each importance-sampling estimate; its standard error of 2 ln B is then about 0.1."""
_BATCH = 100
_TAILS = 4.0
"""Degrees of freedom of the distribution that is sampled, about the fit, so that its weights are bounded."""
_INSIDE = {"gimbal_coulomb_friction", "gimbal_viscous_friction", "gimbal_lag"}
"""Effects that only motor torques or commands show, which the small sets do not have."""
_BINS = 10
_BY_CHANCE = 400
"""Sets of right answers that are drawn from the probabilities; the mean error is then known to 0.002."""
_DRAWS = 5
_SINGLES = 10_000
"""Sets with an effect are numbered from here on."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """One Bayes factor, in two ways, 2 ln B.

    Attributes:
        key: of the effect.
        laplace: as the diagnosis takes it, without held-out runs and scans.
        sampled: by importance sampling.
        std: standard error of that.
    """

    key: str
    laplace: float
    sampled: float
    std: float


def compared(folder: Path, index: int) -> Iterator[Compared]:
    """Yield the Bayes factors of the five likeliest effects of a set, in both ways.

    Args:
        folder: for the set's records and answers.
        index: of the set, from 0; every other one has an effect.
    """
    effect, component = _HIDDEN[index // 2 % len(_HIDDEN)] if index % 2 else (None, "")
    data = folder / f"set_{index}"
    if not (data / SEAL).exists():
        conceal(blind_case(13 + index, effect, component, 2.0), data, folder / f"answer_{index}")
    scenario = read_scenario(SCENARIO)
    platform = nominal_body(scenario)
    runs = data_set_of(read_records(data).runs, scenario, platform).runs
    fit = baseline(runs, None, theta_of(platform.inertia)).model
    screening = screened(runs, None, fit, hypotheses(runs, EFFECTS)[0])
    rng, taken = np.random.default_rng(index), 0
    for candidate in screening.candidates:
        start = next(each.start for each in screening.signatures if each.placed.key == candidate.placed.key)
        prior = SizePrior.of(candidate.effect, start, runs.mean_moment(fit.theta))
        if prior.searched.any() or taken == _DRAWS:
            continue
        taken += 1
        laplace = candidate.chi_square_reduction - candidate.size_penalty
        sampled, std = sampled_evidence(runs, fit, candidate, prior, rng)
        yield Compared(key=candidate.key, laplace=laplace, sampled=sampled, std=std)


def sampled_evidence(
    runs: Runs, fit: Fit, candidate: Candidate, prior: SizePrior, rng: np.random.Generator
) -> tuple[float, float]:
    """Return twice the logarithm of a fitted effect's Bayes factor by importance sampling, and its standard error.

    The other parameters are projected out of the true residual at each sample of the effect's, as a flat prior of them
    has it to first order.

    Args:
        runs: that are fitted.
        fit: without the effect.
        candidate: fitted.
        prior: of its sizes.
        rng: source of the samples.
    """
    model = candidate.fit
    own = model.own(candidate.placed)
    columns = model.signature_of(candidate.placed)
    absent = np.array([each.absent for each in candidate.effect.parameters])
    values = model.effect_values[own]
    # As wide as the data leave them, and no wider than the prior's larger sizes.
    widest = 30.0 * prior.typical
    covariance = np.linalg.inv(columns.T @ columns + np.diag(widest**-2.0))
    proposal = multivariate_t(values, 1.5 * covariance, df=_TAILS, seed=rng)
    drawn = np.reshape(proposal.rvs(_SAMPLES), (_SAMPLES, -1))
    possible = np.all((drawn >= absent) | ~prior.positive, axis=1)
    inside = np.all((drawn >= candidate.placed.bounds[0]) & (drawn <= candidate.placed.bounds[1]), axis=1)
    log_weight = np.full(_SAMPLES, -np.inf)
    which = np.flatnonzero(possible & inside)
    nuisance = orthonormal(np.delete(model.jacobian, np.arange(6, 6 + len(model.effect_values))[own], axis=1))
    squares = np.concatenate(
        [
            _chi_squares(runs, model, own, drawn[which[first : first + _BATCH]], nuisance)
            for first in range(0, len(which), _BATCH)
        ]
    )
    gained = 0.5 * (fit.chi_square - squares)
    log_weight[which] = gained + log_density(prior, drawn[which] - absent) - proposal.logpdf(drawn[which])
    log_mean = float(logsumexp(log_weight)) - np.log(_SAMPLES)
    share = np.exp(log_weight - log_mean)
    return 2.0 * log_mean, 2.0 * float(share.std(ddof=1)) / np.sqrt(_SAMPLES)


def _chi_squares(runs: Runs, model: Fit, own: slice, drawn: Array, nuisance: Array) -> Array:
    effects = np.broadcast_to(model.effect_values, (len(drawn), len(model.effect_values))).copy()
    effects[:, own] = drawn
    edges = np.cumsum([part.shape[1] for part in model.values.effects])[:-1]
    sets = replace(model.values, effects=tuple(np.split(effects, edges, axis=1)))
    blocks = predicted_channels(runs.grid, [each.hooks for each in model.placed], sets)
    residuals = [runs.whitened([block[index] for block in blocks]) for index in range(len(drawn))]
    return np.array([float(np.sum(projected_out(each, nuisance) ** 2)) for each in residuals])


def log_density(prior: SizePrior, values: Array) -> Array:
    """Return the logarithm of the prior's density, shape (N,): an integral over the common factor.

    Args:
        prior: of the sizes.
        values: from where the effect is absent, shape (N, K).
    """
    nodes = np.linspace(-5.0, 5.0, 401)
    factor = np.exp(np.log(10.0) * SETTINGS.size_decades * nodes)
    count = values.shape[1]
    square = ((values / prior.typical) ** 2).sum(axis=1)
    density = -0.5 * square[:, None] / factor**2 - count * np.log(factor)
    weight = -0.5 * nodes**2
    halves = np.log(2.0) * prior.positive.sum()
    constant = halves - 0.5 * count * np.log(2.0 * np.pi) - float(np.log(prior.typical).sum())
    return np.asarray(logsumexp(density + weight, axis=1) - logsumexp(weight) + constant)


def case_of(seed: int, index: int, *, null: bool, as_prior: bool) -> Case:
    """Return a small set without an effect, or with one of typical parameters times a factor that the prior has.

    Args:
        seed: of the pool.
        index: of the set.
        null: whether nothing is hidden.
        as_prior: whether hypotheses are alike, an effect at a component each; else the kinds of effects are.
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index, int(null))))
    own = int(rng.integers(2**31))
    if null:
        return blind_case(own)
    names = sorted(
        name
        for name, kind in LISTED.items()
        if name not in NEVER_HIDDEN | _INSIDE and name in EFFECTS and "cmg" in kind.actuation
    )
    if as_prior:
        names = [name for name in names for _ in LISTED[name].components]
    effect = str(rng.choice(names))
    kind = LISTED[effect]
    factor = float(10.0 ** (SETTINGS.size_decades * rng.standard_normal()))
    if as_prior:  # whose sizes are normal about none, of a scale that has this factor
        factor *= float(np.sqrt(rng.chisquare(len(kind.growing)) / len(kind.growing))) if kind.growing else 1.0
    hidden = HiddenEffect(
        effect=effect,
        component=str(rng.choice(kind.components)),
        parameters=scaled(kind, kind.draw(rng), factor),
    )
    return replace(blind_case(own), effects=(hidden,), stratum="single", notes={"times_typical": factor})


def done(out: Path, seed: int, index: int, *, null: bool, as_prior: bool) -> None:
    """Make and diagnose a set of the pool where that is not done yet; sizes at which nothing flies are drawn anew."""
    name = f"case_{index + 1 + (0 if null else _SINGLES):05d}"
    data, answers = out / "data" / name, out / "answers" / name
    for attempt in range(_DRAWS):
        if (data / SEAL).exists():
            break
        try:
            conceal(case_of(seed, index + _SINGLES * attempt, null=null, as_prior=as_prior), data, answers)
        except (UnreachableError, DivergedError):
            continue
    if (data / SEAL).exists():
        diagnose_case(SCENARIO, data, out / "diagnoses" / name)


def at_share(probabilities: Mapping[str, float], share: float) -> dict[str, float]:
    """Return probabilities as they are with the prior odds of a share of null sets.

    Args:
        probabilities: with the odds of the settings.
        share: of null sets.
    """
    odds = share / (1.0 - share) / SETTINGS.null_prior_odds
    weight = {key: value * (odds if key == NONE else 1.0) for key, value in probabilities.items()}
    total = sum(weight.values())
    return {key: value / total for key, value in weight.items()}


@dataclass(frozen=True, kw_only=True)
class Row:
    """Calibration at one share of null sets.

    Attributes:
        share: of null sets.
        of_none: calibration error of the probability of none.
        of_first: the same of the likeliest answer, right if it is none where nothing is hidden, else if its class has
            the truth, or if it is unknown and no other answer has the truth.
        none_by_chance: mean error of probabilities of none that are calibrated, of as many sets.
        first_by_chance: the same of the likeliest answer.
        right: share of sets whose likeliest answer is right.
    """

    share: float
    of_none: float
    of_first: float
    none_by_chance: float
    first_by_chance: float
    right: float


def row_of(share: float, cases: Sequence[Scored]) -> Row:
    """Return the calibration of a pool at a share of null sets."""
    null = np.array([not truths(case) for case in cases])
    weight = np.where(null, share / null.sum(), (1.0 - share) / (~null).sum())
    stated = [at_share(case.diagnosis.probabilities, share) for case in cases if case.diagnosis is not None]
    first = [max(each, key=lambda key: each[key]) for each in stated]
    right = np.array([_is_right(*each) for each in zip(cases, first, stated, strict=True)])
    none = np.array([each.get(NONE, 0.0) for each in stated])
    likeliest = np.array([each[label] for each, label in zip(stated, first, strict=True)])
    return Row(
        share=share,
        of_none=_error(none, null, weight),
        of_first=_error(likeliest, right, weight),
        none_by_chance=_by_chance(none, weight),
        first_by_chance=_by_chance(likeliest, weight),
        right=float(weight @ right),
    )


def _is_right(case: Scored, label: str, stated: Mapping[str, float]) -> bool:
    """Return whether an answer is right; "unknown" is where something is hidden that no other answer has."""
    keys = {hidden.key for hidden in truths(case)}
    if not keys:
        return label == NONE
    listed = {key for answer in stated for key in answer.split(BETWEEN)}
    return not keys & listed if label == UNKNOWN else bool(keys & set(label.split(BETWEEN)))


def _error(probability: Array, right: Array, weight: Array) -> float:
    index = np.minimum((probability * _BINS).astype(int), _BINS - 1)
    return float(np.abs(np.bincount(index, weights=weight * (right - probability), minlength=_BINS)).sum())


def _by_chance(probability: Array, weight: Array) -> float:
    rng = np.random.default_rng(0)
    return float(
        np.mean([_error(probability, rng.random(len(weight)) < probability, weight) for _ in range(_BY_CHANCE)])
    )


def integral(out: Path) -> None:
    """Print the Bayes factors in both ways, and by how much they differ."""
    every: list[Compared] = []
    for each in islice(chain.from_iterable(compared(out, index) for index in count()), _COMPARED):
        every.append(each)
        print(f"{each.key}: {each.laplace:.2f}, sampled {each.sampled:.2f} ± {each.std:.2f}", flush=True)
    apart = np.array([each.laplace - each.sampled for each in every])
    print(
        f"{len(every)} Bayes factors: Laplace less importance sampling, 2 ln B: mean {apart.mean():+.2f}, "
        f"root mean square {np.sqrt(np.mean(apart**2)):.2f}, at most {np.abs(apart).max():.2f}; standard error of a "
        f"sampled one {np.median([each.std for each in every]):.2f} (median)"
    )


def calibration(out: Path, seed: int, nulls: int, singles: int, *, as_prior: bool) -> None:
    """Make, diagnose and print the pool's calibration at every share."""
    begun = time.perf_counter()
    for wanted, null in ((nulls, True), (singles, False)):
        for index in range(wanted):
            done(out, seed, index, null=null, as_prior=as_prior)
            print(f"\r{'null' if null else 'single'} {index + 1} of {wanted}", end="", flush=True)
    print()
    cases = [case for case in read_cases(out / "diagnoses", out / "answers") if case.diagnosis is not None]
    bare = [case for case in cases if not truths(case)]
    none = [case.diagnosis.probabilities[NONE] for case in bare if case.diagnosis is not None]
    print(f"{len(bare)} null sets, {len(cases) - len(bare)} with an effect; {time.perf_counter() - begun:.0f} s")
    print(f"P(none) of null sets: median {np.median(none):.3f}, least {min(none):.3f}, greatest {max(none):.3f}")
    rows = [row_of(share, cases) for share in SHARES]
    for row in rows:
        print(
            f"{row.share:.0%} null sets: calibration error of none {row.of_none:.3f} (by chance "
            f"{row.none_by_chance:.3f}), of the likeliest answer {row.of_first:.3f} (by chance "
            f"{row.first_by_chance:.3f}); wanted {WANTED}; right in {row.right:.1%}"
        )
    (out / "calibration.json").write_text(json.dumps([row.__dict__ for row in rows], indent=1) + "\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.evidence", description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("integral", "calibration"))
    parser.add_argument("--null", type=int, default=NULL, help=f"sets without an effect, default {NULL}")
    parser.add_argument("--single", type=int, default=SINGLE, help=f"sets with one, default {SINGLE}")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--as-prior", action="store_true", help="every hypothesis as often, in the place of every kind")
    parser.add_argument("--out", type=Path, help="default runs/evidence-SEED")
    chosen = parser.parse_args()
    out = chosen.out or Path("runs") / f"evidence-{chosen.seed}"
    out.mkdir(parents=True, exist_ok=True)
    if chosen.what == "integral":
        integral(out / "integral")
    else:
        calibration(out / "calibration", chosen.seed, chosen.null, chosen.single, as_prior=chosen.as_prior)


if __name__ == "__main__":
    main()
