"""Diagnoses by the library with some of its effects only, which take seconds where all of them take half a minute."""

from __future__ import annotations

import pytest

from testbed.effects.registry import EFFECTS
from testbed.library import prepared_records


def know_only(patch: pytest.MonkeyPatch, *names: str) -> None:
    """Let `tb.diagnose` and `testbed diagnose` know the named effects on the motion only, beside those on the noise."""
    patch.setattr(prepared_records, "EFFECTS", {name: EFFECTS[name] for name in names})
