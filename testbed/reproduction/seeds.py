"""The claims over many seeds: what one seed meets by luck, and another misses by it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from testbed.reproduction.claims import Claim
from testbed.reproduction.judgement import seed_claims
from testbed.reproduction.parts import NOWHERE, Parts
from testbed.reproduction.progress import Progress, silent
from testbed.reproduction.reproduction import Reproduction, flown_of


@dataclass(frozen=True, kw_only=True)
class ClaimOverSeeds:
    """One claim, judged anew with each seed.

    Attributes:
        by_seed: the claim as each seed's flights bear it out.
    """

    by_seed: Mapping[int, Claim]

    @property
    def claim(self) -> Claim:
        """The claim as the first seed has it."""
        return next(iter(self.by_seed.values()))

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of seeds by verdict."""
        return Counter(claim.verdict for claim in self.by_seed.values())

    @property
    def missed_at(self) -> tuple[int, ...]:
        """The seeds that miss it, those with too few flights to tell as well."""
        return tuple(seed for seed, claim in self.by_seed.items() if not claim.met)


def claims_over_seeds(
    first: Reproduction, count: int, progress: Progress = silent, parts: Parts = NOWHERE
) -> tuple[ClaimOverSeeds, ...]:
    """Fly everything that depends on the seed again with following seeds, and judge it.

    Args:
        first: the reproduction with the first seed.
        count: of seeds, the first included; with one there is nothing to compare.
        progress: called with every part.
        parts: that are finished.

    Raises:
        InputError: a worker process died, or memory ran out.
    """
    if count == 1:
        return ()
    by_seed = {first.extent.seed: tuple(seed_claims(first))} | dict(_further(first, count, progress, parts))
    return tuple(
        ClaimOverSeeds(by_seed=dict(zip(by_seed, claims, strict=True)))
        for claims in zip(*by_seed.values(), strict=True)
    )


def _further(
    first: Reproduction, count: int, progress: Progress, parts: Parts
) -> Iterator[tuple[int, Sequence[Claim]]]:
    for seed in range(first.extent.seed + 1, first.extent.seed + count):
        extent = replace(first.extent, seed=seed)
        yield seed, tuple(seed_claims(flown_of(extent, progress, parts)))
