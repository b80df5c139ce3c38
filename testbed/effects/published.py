"""Bring the table of docs/effects.md up to date with the registry.

Run `python -m testbed.effects.published` from the root of the repository.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

import numpy as np

from testbed.effects.contract import NUMBERED, Effect, NamedEffect, Parameter
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS

MARK = "<!-- The rest is written by `python -m testbed.effects.published`. -->"
"""Line of docs/effects.md above which people write."""


def published(page: Path) -> str:
    """Return what the page should contain; the part above the mark is kept.

    Args:
        page: docs/effects.md.
    """
    prose = page.read_text(encoding="utf-8").partition(MARK)[0]
    return f"{prose}{MARK}\n\n{effects_table()}"


def effects_table() -> str:
    """Return every registered effect as a Markdown table, and what would confirm each."""
    effects: list[NamedEffect] = [*EFFECTS.values(), *NOISE_EFFECTS.values()]
    return "\n".join([*_rows(effects), "", *_confirmations(effects), ""])


def _rows(effects: list[NamedEffect]) -> Iterator[str]:
    yield "| id | component | parameters, typical size | needs | what it is | confounded with |"
    yield "|---|---|---|---|---|---|"
    for effect in effects:
        cells = (
            f"`{effect.id}`",
            _components(effect.components),
            "; ".join([*_parameters(effect.parameters), *_written(effect)]),
            ", ".join(need.replace("_", " ") for need in (*effect.needs, *filter(None, [effect.environment]))),
            effect.described(effect.components[0]),
            ", ".join(f"`{other}`" for other in effect.look_alikes),
        )
        yield f"| {' | '.join(cells)} |"


def _components(components: tuple[str, ...]) -> str:
    others = [component for component in components if not any(component in kind for kind in NUMBERED)]
    kinds = [f"{kind[0]}, {kind[1]}, ..." for kind in NUMBERED if kind[0] in components]
    return ", ".join([*others, *kinds])


def _parameters(parameters: tuple[Parameter, ...]) -> Iterator[str]:
    """One entry for neighbours of the same size."""
    for (unit, typical), same in groupby(parameters, key=lambda each: (each.unit, each.typical)):
        names = ", ".join(f"`{parameter.name}`" for parameter in same)
        yield f"{names} {typical:g}{'' if unit == '1' else ' ' + unit}"


def _written(effect: NamedEffect) -> Iterator[str]:
    """What files call the parameters where they have others than those that are searched."""
    if not isinstance(effect, Effect):
        return
    typical = np.array([parameter.typical for parameter in effect.parameters])
    names = [quantity.name for quantity in effect.quantities(typical, np.zeros(len(typical)))]
    if names != [parameter.name for parameter in effect.parameters]:
        yield f"in files {', '.join(f'`{name}`' for name in names)}"


def _confirmations(effects: list[NamedEffect]) -> Iterator[str]:
    yield "| id | what would confirm it |"
    yield "|---|---|"
    for effect in effects:
        yield f"| `{effect.id}` | {effect.confirm} |"


def main() -> None:
    """Write the page."""
    page = Path("docs/effects.md")
    page.write_text(published(page), encoding="utf-8")


if __name__ == "__main__":
    main()
