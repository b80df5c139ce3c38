"""What there is to say of records, once where it is the same of several."""

from __future__ import annotations

from collections.abc import Iterator, Sequence


def grouped(notices: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield what there is to say of records; those of which it is the same are named together.

    Args:
        notices: name of a record, and what there is to say of it.
    """
    for text in dict.fromkeys(text for _, text in notices):
        names = [name for name, other in notices if other == text]
        yield f"{', '.join(names)}{', each' if len(names) > 1 else ''}: {text}"
