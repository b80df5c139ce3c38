"""The interface of an executor, which flies the blocks of a campaign on some machines, in any order."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from testbed.campaign.plan import Block, CampaignPlan
from testbed.campaign.rows import Row

MOST_DEATHS = 3
"""Workers that a block may take down before it is given up: bad luck strikes a block once, seldom twice."""

Notify: TypeAlias = Callable[[str], None]
"""Called with a sentence on each fault that was repaired."""


@dataclass(frozen=True, kw_only=True)
class BlockRows:
    """A finished block.

    Attributes:
        block: which.
        rows: one per run, in the order of its seeds.
    """

    block: Block
    rows: list[Row]


class Executor(Protocol):
    """Flies blocks of runs. The results of a block do not depend on the executor."""

    def finished(self, plan: CampaignPlan, blocks: Sequence[Block], notify: Notify) -> Generator[BlockRows]:
        """Yield each block once, as it is finished; no more than a few are held at a time.

        Closing the iterator early gives up what is being flown.

        Args:
            plan: of the campaign.
            blocks: to fly.
            notify: called with a sentence for each worker that died.

        Raises:
            InputError: the workers cannot be reached, or a block took every worker down that tried it.
        """
        ...
