"""testbed reproduce: the paper's tables and figures from this testbed, in one run."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from testbed.campaign.local import usable_cores
from testbed.cli.console import command_line, say, show
from testbed.cli.failures import COMPLETED, INTERRUPTED
from testbed.cli.parts_progress import parts_progress
from testbed.delivery.folder import reserved_folder
from testbed.delivery.provenance import provenance_of_several
from testbed.delivery.reproduction_folder import write_reproduction
from testbed.reproduction.claims import Claim
from testbed.reproduction.judgement import claims_of
from testbed.reproduction.reproduction import SCENARIOS, full_extent, quick_extent, reproduce
from testbed.scenario.reader import scenario_file
from testbed.scenario.shipped import shipped_scenario


def reproduce_paper(out: Path | None, seed: int, runs: int | None, *, quick: bool) -> int:
    """Make everything, write the folder, print the claims; returns the exit code.

    Raises:
        InputError: the folder cannot be used, or a worker process died.
    """
    make = quick_extent if quick else full_extent
    extent = make(seed=seed, workers=usable_cores(), runs=runs)
    files = [scenario_file(shipped_scenario(name)) for name in SCENARIOS]
    deciding = {name: str(value) for name, value in asdict(extent).items()}
    origin = provenance_of_several("reproduction", files, command_line(), deciding)
    try:
        with reserved_folder(out, "reproduction") as folder:
            with parts_progress() as progress:
                reproduction = reproduce(extent, progress)
                claims = tuple(claims_of(reproduction))
            folder.deliver(lambda place: write_reproduction(place, origin, reproduction, claims))
    except KeyboardInterrupt:
        say("Interrupted; nothing was written.")
        return INTERRUPTED
    show(_claims_table(claims))
    say()
    say(f"Took       {reproduction.seconds:.0f} s with {extent.workers} processes")
    say(f"Folder     {folder.path}")
    say(f"Page       {folder.path / 'reproduction.html'}")
    say(f"Recording  testbed view {folder.path}")
    return COMPLETED


def _claims_table(claims: tuple[Claim, ...]) -> Table:
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for title in ("Claim", "Target", "Measured", ""):
        table.add_column(title)
    for claim in claims:
        verdict = Text(claim.verdict, style="green" if claim.met else "yellow")
        table.add_row(Text(f"{claim.subject}: {claim.what}"), Text(claim.target), Text(claim.measured), verdict)
    return table
