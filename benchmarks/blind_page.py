"""docs/blind.md: the score card of the blind set as a page, from what score.json holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from typing import Any

from benchmarks.blind_baselines import BIC, ORACLE, OURS, REDUCTION, SINDY, Comparison
from benchmarks.blind_unlisted import Kind
from testbed.scoring.card import ScoreCard, card_content

_METHODS = (OURS, REDUCTION, BIC, SINDY, ORACLE)
_HEAD = """# The blind set

Written by `make blind`; do not edit. What each figure means: [scoring.md](scoring.md). Craft with reaction wheels, free
and on an air bearing, have [a set of their own](blind-wheels.md).

"""
_METHODS_EXPLAINED = f"""
The other methods see the same records. *{REDUCTION}* names the hypothesis that takes most off χ²; *{BIC}* the one with
the best Bayesian information criterion, without a test; both choose among all hypotheses of the diagnosis, refitted
where it refitted them, else linearised. *{SINDY}* is the sparse regression (STLSQ of pysindy) of the differentiated
residual torque on the torques that each hypothesis would make, linearised. The *{ORACLE}* knows which effect it is,
and only tests whether a likelihood-ratio test finds it at 5 % family-wise error: no test of these data has more power.
"""
_UNMODELLED_TORQUES = """
The fourth column is the residual of an unmodelled torque after the best fit of one effect, in data without noise
(`python -m benchmarks.blind_unlisted`). The oracle knows this residual sample by sample, but for its size, and tests
for it at 1 %; no test of these data with so few false alarms has more power. Shares are of what it recognises, and of
what the diagnosis called unexplained.
"""


@dataclass(frozen=True, kw_only=True)
class Making:
    """How a score came about.

    Attributes:
        command: that makes it.
        seed: of the set.
        where: date, machine and versions.
        making_seconds: that it took to make each case.
        diagnosis_seconds: that each diagnosis took.
    """

    command: str
    seed: int
    where: str
    making_seconds: tuple[float, ...]
    diagnosis_seconds: tuple[float, ...]


def content_of(
    card: ScoreCard, others: Sequence[Comparison], unlisted: Sequence[Kind], making: Making
) -> dict[str, Any]:
    """Return what score.json holds."""
    return card_content(card) | {
        "others": [asdict(each) for each in others],
        "unlisted": [asdict(each) for each in unlisted],
        "making": asdict(making),
    }


def page(content: Mapping[str, Any]) -> str:
    """Return the page.

    Args:
        content: of score.json.
    """
    lines = [
        *opening(content),
        "\n## Figures\n",
        *figures(content),
        "\n## Other methods on the same cases\n",
        *_comparisons(content["others"]),
        _METHODS_EXPLAINED,
        *_unlisted(content["unlisted"]),
        "## How far probabilities can be believed\n",
        *_reliability(content["calibration"]),
        "\n## What was reported first\n",
        *confusion(content),
    ]
    return _HEAD + "\n".join(lines) + "\n"


def opening(content: Mapping[str, Any]) -> Iterator[str]:
    """Yield what was made, scored and where; `content` as for `page`."""
    making = content["making"]
    yield (
        f"`{making['command']}`, seed {making['seed']}, {content['cases']} cases, {content['sealed']} answers as they "
        f"were sealed; {len(content['failures'])} cases without a diagnosis."
    )
    yield ""
    yield making["where"] + "."
    yield ""
    yield _seconds("Making a case", making["making_seconds"])
    yield _seconds("A diagnosis", making["diagnosis_seconds"])


def _seconds(what: str, seconds: Sequence[float]) -> str:
    if not seconds:
        return f"{what}: no times were kept."
    ordered = sorted(seconds)
    middle, most = ordered[len(ordered) // 2], ordered[-1]
    return f"{what} took {middle:.1f} s in the median, {most:.1f} s at most, {sum(ordered) / 60.0:.0f} min in all."


def _table(*rows: Sequence[str]) -> Iterator[str]:
    head, *rest = rows
    yield f"| {' | '.join(head)} |"
    yield "|---" * len(head) + "|"
    yield from (f"| {' | '.join(row)} |" for row in rest)


def figures(content: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of figures; `content` as for `page`."""
    table = [("", "value", "of", "95 % interval", "wanted")]
    for part, own in groupby(content["rows"], key=lambda row: row["part"]):
        table.append((f"**{part}**", "", "", "", ""))
        for row in own:
            table.append((row["what"], _value(row), str(row["of"]), _interval(row), row["wanted"]))
            if row["limit_wanted"]:
                table.append(("its one-sided 95 % limit", f"{row['upper_limit']:.1%}", "", "", row["limit_wanted"]))
    return _table(*table)


def _comparisons(others: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    methods = [method for method in _METHODS if any(method in each["rows"] for each in others)]
    table = [("", "of", *methods)]
    for each in others:
        rows = each["rows"]
        of = rows[OURS]["of"]
        cells = [_beside(rows[method], of) if method in rows else "" for method in methods]
        table.append((f"{each['part']}: {each['what']}", str(of), *cells))
    return _table(*table)


def _beside(row: Mapping[str, Any], usual: int) -> str:
    """Return a method's share with its interval, and of how many cases where it was asked of fewer."""
    of = "" if row["of"] == usual else f", of {row['of']}"
    return f"{_value(row)} ({_interval(row)}{of})"


def _unlisted(kinds: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the section on unlisted effects; nothing where it was not asked what could be known of them."""
    if not kinds:
        return
    table = [("hidden", "of", "sigma shown", "sigma of the residual after the best fit", "oracle", "this diagnosis")]
    for each in kinds:
        left, power, said = f"{each['left']:.1f}", f"{each['power']:.0%}", f"{each['recognised']:.0%}"
        table.append(
            (f"{each['effect']} at {each['sigma']:g}", str(each["of"]), f"{each['shown']:.1f}", left, power, said)
        )
    yield "## What could be known of unmodelled torques\n"
    yield from _table(*table)
    for sigma, group in groupby(kinds, key=lambda each: each["sigma"]):
        own = list(group)
        power = sum(each["power"] * each["of"] for each in own) / sum(each["of"] for each in own)
        yield f"\nAt {sigma:g} sigma, the oracle recognises {power:.0%} in the mean."
    yield _UNMODELLED_TORQUES


def _reliability(bins: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    table = [("stated probability", "mean", "share right", "of")]
    for each in bins:
        edges, cells = f"{each['low']:.1f} to {each['high']:.1f}", f"{each['probability']:.3f}"
        table.append((edges, cells, f"{each['right']:.3f}", str(each["of"])))
    return _table(*table)


def confusion(content: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of what was said first; `content` as for `page`."""
    table = content["confusion"]
    cells = {hidden: ", ".join(f"{said} {count}" for said, count in counts.items()) for hidden, counts in table.items()}
    return _table(("hidden", "reported first, times"), *cells.items())


def _value(row: Mapping[str, Any]) -> str:
    if row["value"] is None:
        return "-"
    return f"{row['value']:.3g}" if row["hits"] is None else f"{row['value']:.1%}"


def _interval(row: Mapping[str, Any]) -> str:
    if row["low"] is None or row["high"] is None:
        return "-"
    if row["hits"] is None:
        return f"{row['low']:.3g} to {row['high']:.3g}"
    return f"{row['low']:.1%} to {row['high']:.1%}"
