"""comparison.json of runs, or of campaigns."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from testbed.formats.campaign import CampaignResult
from testbed.formats.parts import FilesProvenance, Part
from testbed.formats.run import RunResult


class ComparisonResult(Part):
    """comparison.json: the results of several runs, or of several campaigns, as their folders hold them."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this format."""
    kind: Literal["run", "campaign"]
    """What is compared."""
    results: dict[str, RunResult] | dict[str, CampaignResult]
    """The content of each folder's result.json, or montecarlo.json, by the folder's name."""
    provenance: FilesProvenance
    """The results that were compared, with their hashes, and versions."""
