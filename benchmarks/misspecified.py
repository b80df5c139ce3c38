"""Null sets whose noise, clocks and instruments are not as stated: python -m benchmarks.misspecified [--kinds ...].

--sets N of every kind, --seed S; every kind has the same flights, so that kinds are compared on equal terms. What is
there already, made or diagnosed, is kept: an interrupted run goes on where it was. Remove OUT/KIND/diagnoses to
diagnose anew.

A name is wrong if no member of its equivalence class is what was done to the set: a late sample named as a latency of
the gyro is right. The table, of all that is in OUT, goes to OUT/misspecified.json and .md, with --write into docs/ too.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import beta

from benchmarks.blind_diagnosis import diagnose_case
from benchmarks.table import DOCS, here_and_now
from concealing.case import Case, Instruments
from concealing.effect import HiddenEffect
from concealing.files import conceal
from concealing.power import UnreachableError
from concealing.sealing import SEAL
from concealing.strata import ATTEMPTS, bare_case, drawn_actuation, small_effects
from testbed.scoring.case import Case as Scored
from testbed.scoring.case import read_cases
from testbed.scoring.judging import named, recognised_as_unknown

SCENARIO = Path("scenarios/diagnose.toml")
SEED, SETS = 6200, 40
MOST_WRONG, MOST_UNEXPLAINED = 0.05, 0.10
_SMALL, _SMALL_SIZE = 3, 0.5
_TWELVE_BIT = 2.0 * np.pi / 2**12
_ECCENTRICITY = 5e-4
"""rad: five times the noise of a good encoder, a fifth of a degree of arc across its disc."""
_WALK = 0.05
"""Of the gyro's bias after a second, in its noise: 8e-5 rad/s/√s, as much as poor MEMS gyros have."""
_LATE = frozenset({"telemetry_skew"})
_EARLY = frozenset({"telemetry_skew", "gyro_latency", "actuator_delay"})
_COLOR = frozenset({"gyro_noise_color"})
_NOISE = frozenset({"gyro_noise"})
_SMOOTHED = frozenset({"gyro_averaging", "gyro_latency", "gyro_bandwidth", "telemetry_skew", "gyro_noise_color"})


@dataclass(frozen=True, kw_only=True)
class Kind:
    """One kind of misspecification.

    Attributes:
        words: what it is.
        instruments: what they do.
        telemetry: fields of the telemetry that are changed.
        effects: hidden as well, of the gyro.
        small_effects: number of library effects of half a detectable size.
        units: whether it takes CMG units.
        right: ids of effects that are right names for it.
    """

    words: str
    instruments: Instruments = field(default_factory=Instruments)
    telemetry: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[HiddenEffect, ...] = ()
    small_effects: int = 0
    units: bool = False
    right: frozenset[str] = frozenset()


def _walk(share: float) -> HiddenEffect:
    """Return a bias that walks by a share of the noise in a second."""
    noise = 0.001658
    still = {f"drift_{axis}": 0.0 for axis in "xyz"}
    return HiddenEffect(effect="gyro_drift", component="gyro", parameters={**still, "random_walk": share * noise})


def _correlated(correlation: float) -> Kind:
    words = f"noise correlated by {correlation:+.1f}, first-order autoregression"
    return Kind(words=words, instruments=Instruments(noise_correlation=correlation), right=_COLOR)


def _stated(share: float) -> Kind:
    """Return the kind whose stated noise is wrong by a share of the actual one."""
    telemetry = {"stated_noise": 1.0 + share}
    return Kind(
        words=f"noise stated {share:+.0%} wrong", telemetry=telemetry, right=_NOISE if share < 0.0 else frozenset()
    )


def _delayed(delay: float) -> Kind:
    words = f"actuators' telemetry {abs(1e3 * delay):.0f} ms {'late' if delay > 0.0 else 'early'}"
    return Kind(words=words, instruments=Instruments(telemetry_delay=delay), right=_LATE if delay > 0.0 else _EARLY)


KINDS: dict[str, Kind] = {
    "none": Kind(words="nothing"),
    **{f"ar{100 * each:+.0f}": _correlated(each) for each in (0.2, 0.3, 0.5, -0.2, -0.3, -0.5)},
    "ar_in_white": Kind(
        words="noise of which 40 % is correlated by +0.8, the rest white",
        instruments=Instruments(noise_correlation=0.8, noise_white=0.6),
        right=_COLOR,
    ),
    "t5": Kind(words="noise of Student's t, 5 degrees", instruments=Instruments(tail_freedom=5.0)),
    "outliers": Kind(words="1 % of the gyro's samples are outliers", telemetry={"outliers": 0.01}, right=_NOISE),
    **{f"sigma{100 * each:+.0f}": _stated(each) for each in (-0.1, 0.1, -0.2, 0.2)},
    "sigma_by_run": Kind(
        words="noise different by run, up to ±20 %", instruments=Instruments(noise_by_run=0.2), right=_NOISE
    ),
    "jitter": Kind(words="gyro's samples jitter by 0.5 ms", instruments=Instruments(jitter=5e-4), right=_NOISE),
    "averaging": Kind(words="gyro averages over its period", instruments=Instruments(averaging=True), right=_SMOOTHED),
    "anti_alias": Kind(
        words="second-order filter at 0.4 of the gyro's rate",
        instruments=Instruments(anti_alias=0.4),
        right=_SMOOTHED,
    ),
    "eccentricity": Kind(
        words="encoders eccentric by 0.5 mrad", instruments=Instruments(eccentricity=_ECCENTRICITY), units=True
    ),
    "twelve_bit": Kind(words="encoders of 12 bit", telemetry={"encoder_step": _TWELVE_BIT}, units=True),
    "encoders_late": Kind(
        words="encoders late by half a sample", instruments=Instruments(encoder_delay=0.5), units=True, right=_LATE
    ),
    "bias_walk": Kind(
        words="bias walks",
        effects=(_walk(_WALK),),
        right=frozenset({"gyro_rate_random_walk", "gyro_drift", "gyro_bias", "gyro_noise_color"}),
    ),
    "bias_walk_fast": Kind(
        words="bias walks by a third of its noise in a second",
        effects=(_walk(1.0 / 3.0),),
        right=frozenset({"gyro_rate_random_walk"}),
    ),
    "clock_skew": Kind(
        words="clocks apart by 1 ms at the end",
        instruments=Instruments(clock_skew=1e-3),
        right=_EARLY | {"gyro_clock_drift"},
    ),
    **{
        f"telemetry{1e3 * each:+.0f}ms": _delayed(each)
        for each in (0.001, 0.005, 0.015, 0.031, -0.001, -0.005, -0.015, -0.031)
    },
    **{
        f"actuators_every_{each}": Kind(
            words=f"actuators sampled with every {word} sample of the gyro",
            telemetry={"actuator_every": each},
            units=True,
        )
        for each, word in ((2, "second"), (4, "fourth"))
    },
    "three_small": Kind(words="three effects of half a detectable size", small_effects=_SMALL, units=True),
}
"""By name; what is early or late is so against the gyro."""


def case_of(kind: Kind, seed: int, index: int) -> Case:
    """Return a set of a kind: a function of the seed and of its number, the flight the same for every kind."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    actuation = drawn_actuation(rng, None)
    case = bare_case(rng, SCENARIO, "cmg" if kind.units else actuation, None)
    telemetry = replace(case.telemetry, **kind.telemetry)
    if kind.units:
        telemetry = replace(telemetry, momentum="gimbal_angle")
    case = replace(case, telemetry=telemetry, instruments=kind.instruments, effects=kind.effects)
    for _ in range(ATTEMPTS):
        try:
            return replace(case, effects=(*case.effects, *small_effects(rng, case, kind.small_effects, _SMALL_SIZE)))
        except UnreachableError:
            continue
    raise UnreachableError(f"no set of {ATTEMPTS} can show {kind.words}")


def done(name: str, seed: int, index: int, out: Path) -> None:
    """Make and diagnose a set where that is not done yet."""
    folder, case = out / name, f"case_{index + 1:04d}"
    if not (folder / "data" / case / SEAL).exists():
        conceal(case_of(KINDS[name], seed, index), folder / "data" / case, folder / "answers" / case)
    diagnose_case(SCENARIO, folder / "data" / case, folder / "diagnoses" / case)


@dataclass(frozen=True, kw_only=True)
class Row:
    """What was said of the sets of one kind.

    Attributes:
        kind: its name.
        words: what it is.
        seed: of its sets.
        sets: how many.
        silent: without any name, and nothing unexplained.
        right: with right names alone.
        wrong: with a wrong name.
        unexplained: verdict `unexplained`.
        failed: without a diagnosis.
        names: wrong ones, and those of failures.
    """

    kind: str
    words: str
    seed: int
    sets: int
    silent: int
    right: int
    wrong: int
    unexplained: int
    failed: int
    names: tuple[str, ...]

    @property
    def kept(self) -> bool:
        """Whether the shares are as small as they should be."""
        return (
            self.wrong <= MOST_WRONG * self.sets
            and self.unexplained <= MOST_UNEXPLAINED * self.sets
            and self.failed == 0
        )


def row_of(name: str, cases: Sequence[Scored], seed: int) -> Row:
    """Return the row of a kind.

    Args:
        name: of the kind.
        cases: its sets, diagnosed.
        seed: of these.
    """
    wrong = [tuple(wrong_names(case, _right(name, case))) for case in cases]
    unexplained = [recognised_as_unknown(case) for case in cases]
    right = sum(bool(named(case)) and not names for case, names in zip(cases, wrong, strict=True))
    return Row(
        kind=name,
        words=KINDS[name].words,
        seed=seed,
        sets=len(cases),
        silent=sum(
            case.diagnosis is not None and not named(case) and not unknown
            for case, unknown in zip(cases, unexplained, strict=True)
        ),
        right=right,
        wrong=sum(map(bool, wrong)),
        unexplained=sum(unexplained),
        failed=sum(case.diagnosis is None for case in cases),
        names=tuple(each for names in wrong for each in names),
    )


def _right(name: str, case: Scored) -> Collection[str]:
    small = {hidden.effect for hidden in case.answer.effects} if KINDS[name].small_effects else set()
    return KINDS[name].right | small


def wrong_names(case: Scored, right: Collection[str]) -> Iterator[str]:
    """Yield the names of a diagnosis of whose classes no member is right."""
    for step in named(case):
        if not {each.effect for each in step.alike} & set(right):
            yield step.key


def table(rows: Sequence[Row]) -> str:
    """Return the table."""
    lines = [
        "| kind | seed | sets | no name | right names | wrong | at most (95 %) | unexplained | failed | wrong names |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in (*rows, _together(rows)):
        most = _upper(row.wrong, row.sets)
        names = ", ".join(f"`{each}`" for each in row.names)
        cells = (
            row.words,
            row.seed or "",
            row.sets,
            row.silent,
            row.right,
            row.wrong,
            f"{most:.0%}",
            row.unexplained,
            row.failed,
            names,
        )
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


def _together(rows: Sequence[Row]) -> Row:
    counts = {
        name: sum(getattr(row, name) for row in rows)
        for name in ("sets", "silent", "right", "wrong", "unexplained", "failed")
    }
    return Row(kind="all", words="all of them", seed=0, names=(), **counts)


def _upper(count: int, sets: int) -> float:
    """Return the upper limit of a share, one-sided 95 % (Clopper and Pearson, 1934)."""
    return 1.0 if count == sets else float(beta.ppf(0.95, count + 1, sets - count))


def main() -> None:
    chosen = _arguments()
    out: Path = chosen.out or _folder(chosen.seed)
    orders = [(name, index) for index in range(chosen.sets) for name in chosen.kinds]
    with ProcessPoolExecutor(chosen.jobs) as pool:
        futures = [pool.submit(done, name, chosen.seed, index, out) for name, index in orders]
        for count, future in enumerate(futures, start=1):
            future.result()
            print(f"\r{count} of {len(orders)}", end="", flush=True)
    print()
    seeds = (chosen.seed, *chosen.also)
    rows = [row for name in KINDS if (row := _first_row(name, [out, *map(_folder, chosen.also)], seeds)) is not None]
    text = page(rows)
    print(text)
    content = {"seeds": seeds, "where": here_and_now(), "kinds": [asdict(row) for row in rows]}
    for folder in (out, DOCS) if chosen.write else (out,):
        (folder / "misspecified.json").write_text(
            json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
        )
        (folder / "misspecified.md").write_text(text, encoding="utf-8")


def _folder(seed: int) -> Path:
    return Path("runs") / f"misspecified-{seed}"


def _first_row(name: str, folders: Sequence[Path], seeds: Sequence[int]) -> Row | None:
    """Return the row of a kind by the first seed of which sets were diagnosed; None where there are none."""
    for folder, seed in zip(folders, seeds, strict=True):
        if cases := diagnosed_sets(folder / name):
            return row_of(name, cases, seed)
    return None


def diagnosed_sets(folder: Path) -> list[Scored]:
    """Return the sets of a kind that were diagnosed so far, refused ones among them."""
    done = {path.name for path in folder.glob("diagnoses/*") if any(path.iterdir())}
    if not done:
        return []
    return [case for case in read_cases(folder / "diagnoses", folder / "answers") if case.name in done]


def page(rows: Sequence[Row]) -> str:
    """Return the page of docs/misspecified.md."""
    missed = [row.kind for row in rows if not row.kept]
    seeds = dict.fromkeys(row.seed for row in rows)
    shown = [row.kind for row in rows if _upper(row.wrong, row.sets) <= MOST_WRONG]
    return f"""# Null sets that are not as stated

The concealing engine flies sets without any effect of the library, and changes what nobody states: the colour and the
tails of the gyro's noise, its level, clocks, encoders. A name is wrong unless its equivalence class has a member that
describes what was done: `gyro_noise_color` is right where the noise has a colour, `gyro_latency` where the actuators'
telemetry is early. Wanted: a wrong name in at most {MOST_WRONG:.0%} of each kind, `unexplained` in at most
{MOST_UNEXPLAINED:.0%}. Exceeded by: {", ".join(missed) or "none"}.
At most {MOST_WRONG:.0%} with 95 % confidence, for which 59 sets without a wrong name are needed:
{", ".join(shown) or "none"}.

Command: `python -m benchmarks.misspecified --kinds KINDS --sets N --seed S` for each of the seeds
{", ".join(map(str, seeds))}, and with `--also` and `--write` for the table. {here_and_now()}

{table(rows)}
"""


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.misspecified", description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS), metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--sets", type=int, default=SETS, help=f"of every kind, default {SETS}")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--also", nargs="*", type=int, default=[], help="seeds for kinds of which --seed has no sets")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--write", action="store_true", help="write the table into docs/ too")
    parser.add_argument("--out", type=Path, help="default runs/misspecified-SEED")
    return parser.parse_args()


if __name__ == "__main__":
    main()
