"""All claims of a reproduction, in the order in which the page shows them."""

from __future__ import annotations

from collections.abc import Iterator

from testbed.reproduction.alignment_claims import alignment_claims
from testbed.reproduction.claims import Claim, table1_claims, table2_claims, whiteness_claim
from testbed.reproduction.reproduction import Flown, Reproduction
from testbed.reproduction.zero_g_claims import zero_g_claims


def claims_of(reproduction: Reproduction) -> Iterator[Claim]:
    """Judge every figure that the reproduction has to reach, from its own numbers."""
    yield from table1_claims(reproduction.table1)
    yield from seed_claims(reproduction)
    yield _duration(reproduction)


def seed_claims(flown: Flown) -> Iterator[Claim]:
    """Judge what depends on the seed."""
    yield from table2_claims(flown.table2)
    yield whiteness_claim(flown.whiteness)
    yield from zero_g_claims(flown.table3)
    yield from alignment_claims(flown.alignments)


def _duration(reproduction: Reproduction) -> Claim:
    limit = reproduction.extent.time_limit
    return Claim(
        subject="Time",
        what=f"of this reproduction, {reproduction.extent.workers} processes",
        target=f"under {limit / 60:.0f} min",
        measured=f"{reproduction.seconds / 60:.1f} min",
        met=reproduction.seconds < limit,
        test="could fail; other work on the machine counts",
    )
