"""What all tests share."""

from __future__ import annotations

import gc

_RARELY = (50_000, 20, 100)
"""Objects, and collections of the younger ones, after which garbage is collected; by default 700, 10 and 10."""


def pytest_collection_finish() -> None:
    """Leave a million imported objects out of garbage collections: these took 3 to 5 % of the suite's time."""
    gc.freeze()
    gc.set_threshold(*_RARELY)
