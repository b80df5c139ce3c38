"""docs/zero-g-story.md and its picture: what was hidden in the campaigns, what was named, and what that did to J."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from testbed.campaign.statistics import NORMAL_95
from testbed.dynamics.inertia import PARAMETER_NAMES

_HEAD = """# What a missing effect does to five parabolas

Written by `python -m benchmarks.zero_g_story`; do not edit. {measured}.

Five flights in the cabin, released with a spin and a drift, flown on the platform of the paper's Table 3 and modelled
as its CAD model: {shortest:.1f} to {longest:.1f} s usable, 16 Hz, 0.095 deg/s. Something is hidden in the flown
platform. `testbed diagnose` sees four of the flights, holds out the fifth, and does not know what is
hidden; every model estimates J and the initial rates jointly with its effects. {campaigns} campaigns of each kind,
each with its own noise and releases.

"""
_HOW = """
*Right first* is the hidden effect in its component, at the head of the list; *in the set*, it or an indistinguishable
one that the diagnosis lists with it. *J holds*: share of the 95 % intervals of the six inertia parameters that hold
the truth, with the rms error in estimated standard deviations. *Left out* is the fit of J and initial rates alone;
*named* is the fit with all that the diagnosis added. Gaps are medians, in σ of the noise.

![Errors of J in claimed standard deviations, without and with what was named]({picture})

"""
_LIMITS = """
## What to know of it

- Each record states its first contact, as operators would. The search for contacts in the record (`cut_at_contact`)
  assumes the nominal model, and a gyro that is 10 ms late makes it see contacts everywhere: two campaigns of the
  reproduction kept no flight of 2 s.
- In flights as short as these a late gyro and a slow one are all but the same: where the verdict is `ambiguous`, both
  are listed.
- What the diagnosis adds beside the right effect is counted as said, in the table below.
"""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One campaign, diagnosed.

    Attributes:
        hidden: in words.
        key: effect and component of it; empty for nothing.
        campaign: number.
        verdict: of the diagnosis.
        named: what it added, in its order.
        look_alikes: of the first of them.
        gap: of the fitted flights before and after, σ.
        heldout_gap: of the one held out.
        without: errors of the six inertia parameters, in claimed standard deviations, nothing added.
        with_named: with all that was added.
        usable: of each flight, s.
    """

    hidden: str
    key: str
    campaign: int
    verdict: str
    named: Sequence[str]
    look_alikes: Sequence[str]
    gap: Sequence[float]
    heldout_gap: Sequence[float]
    without: Sequence[float]
    with_named: Sequence[float]
    usable: Sequence[float]

    @property
    def first(self) -> bool:
        """Whether the hidden effect heads the list; of nothing, whether the verdict is none."""
        return self.verdict == "none" if not self.key else self.key in self.named[:1]

    @property
    def in_set(self) -> bool:
        """Whether the hidden effect, or nothing, is what is named or in its equivalence class."""
        return self.first or self.key in self.look_alikes


def held_share(deviations: Sequence[Sequence[float]]) -> float:
    """Return the share of 95 % intervals that hold the truth, of errors in claimed standard deviations."""
    return float(np.mean(np.abs(np.array(deviations)) <= NORMAL_95))


def page(outcomes: Sequence[Outcome], measured: str, picture: str) -> str:
    """Return the page.

    Args:
        outcomes: of whole campaigns, of every situation.
        measured: when and on what.
        picture: its path from the page.
    """
    usable = np.concatenate([each.usable for each in outcomes])
    situations = _by_situation(outcomes)
    head = _HEAD.format(measured=measured, shortest=usable.min(), longest=usable.max(), campaigns=len(situations[0][1]))
    table = [
        "| hidden | right first | in the set | gap | held out | J holds, left out | J holds, named |",
        "|---|---|---|---|---|---|---|",
        *(_row(hidden, own) for hidden, own in situations),
    ]
    said = ["| hidden | verdict | named | times |", "|---|---|---|---|", *_said(situations)]
    return (
        head + "\n".join(table) + "\n" + _HOW.format(picture=picture) + _LIMITS.lstrip() + "\n" + "\n".join(said) + "\n"
    )


def _by_situation(outcomes: Sequence[Outcome]) -> list[tuple[str, list[Outcome]]]:
    order = list(dict.fromkeys(each.hidden for each in outcomes))
    ordered = sorted(outcomes, key=lambda each: order.index(each.hidden))
    return [(hidden, list(own)) for hidden, own in groupby(ordered, key=lambda each: each.hidden)]


def _row(hidden: str, own: Sequence[Outcome]) -> str:
    first, in_set = sum(each.first for each in own), sum(each.in_set for each in own)
    gap, heldout = np.median([each.gap for each in own], axis=0), np.median([each.heldout_gap for each in own], axis=0)
    cells = (
        hidden,
        f"{first} of {len(own)}",
        f"{in_set} of {len(own)}",
        f"{gap[0]:.2f} → {gap[1]:.2f}",
        f"{heldout[0]:.2f} → {heldout[1]:.2f}",
        _held([each.without for each in own]),
        _held([each.with_named for each in own]),
    )
    return f"| {' | '.join(cells)} |"


def _held(deviations: Sequence[Sequence[float]]) -> str:
    return f"{held_share(deviations):.0%}; {np.sqrt(np.mean(np.square(deviations))):.1f} σ"


def _said(situations: Sequence[tuple[str, Sequence[Outcome]]]) -> Iterator[str]:
    for hidden, own in situations:
        counts = Counter((each.verdict, ", ".join(each.named) or "-") for each in own)
        for (verdict, named), times in counts.most_common():
            yield f"| {hidden} | {verdict} | {named} | {times} |"


def draw(outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw every error of J without and with what was named, a panel for each situation."""
    situations = _by_situation(outcomes)
    figure = Figure(figsize=(3.4 * len(situations), 3.2), layout="constrained")
    FigureCanvasAgg(figure)
    panels = np.atleast_1d(figure.subplots(1, len(situations), sharey=True))
    places = np.arange(len(PARAMETER_NAMES))
    for axes, (hidden, own) in zip(panels, situations, strict=True):
        axes.axhspan(-NORMAL_95, NORMAL_95, color="#d9e6d4", zorder=0)
        for shift, color, label, errors in (
            (-0.15, "#b5482f", "left out", [each.without for each in own]),
            (0.15, "#2b5c8a", "named", [each.with_named for each in own]),
        ):
            points = np.array(errors)
            axes.scatter(np.tile(places + shift, (len(points), 1)), points, s=8, color=color, alpha=0.7, label=label)
        axes.set_title(hidden, fontsize=10)
        axes.set_xticks(places, PARAMETER_NAMES, fontsize=8)
        axes.set_yscale("symlog", linthresh=5.0)
        axes.set_yticks([-20, -5, -2, 0, 2, 5, 20], ["-20", "-5", "-2", "0", "2", "5", "20"], fontsize=8)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("error / claimed standard deviation", fontsize=9)
    panels[0].legend(fontsize=8, loc="upper left", frameon=False)
    figure.savefig(path, dpi=120)
