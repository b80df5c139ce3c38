"""testbed reproduce: the paper's tables and figures from this testbed, in one run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from testbed.campaign.local import usable_cores
from testbed.campaign.manifest import deciding_versions
from testbed.cli.console import command_line, entry, further_command, say, show, warn
from testbed.cli.failures import COMPLETED, INTERRUPTED
from testbed.cli.options import require_folder
from testbed.cli.parts_progress import parts_progress
from testbed.errors import InputError
from testbed.files import TextFile
from testbed.outputs.folder import OutputFolder, reserved_folder
from testbed.outputs.provenance import provenance_of_several
from testbed.outputs.reproduction_folder import write_reproduction
from testbed.reproduction.claims import Claim
from testbed.reproduction.finished_parts import finished_parts, require_reproduction
from testbed.reproduction.judgement import claims_of
from testbed.reproduction.reproduction import SCENARIOS, Extent, Reproduction, full_extent, quick_extent, reproduce
from testbed.reproduction.seeds import ClaimOverSeeds, claims_over_seeds
from testbed.scenario.reader import scenario_file
from testbed.scenario.shipped import shipped_scenario


def reproduce_paper(out: Path | None, seed: int, runs: int | None, *, quick: bool, resume: bool, seeds: int) -> int:
    """Make everything, write the folder, print the claims; returns the exit code.

    Raises:
        InputError: the folder cannot be used, or a worker process died; what was finished is kept.
    """
    require_folder("reproduction", out, resume=resume)
    make = quick_extent if quick else full_extent
    extent = make(seed=seed, workers=usable_cores(), runs=runs)
    files = [scenario_file(shipped_scenario(name)) for name in SCENARIOS]
    deciding = {name: str(value) for name, value in (asdict(extent) | {"seeds": seeds}).items()}
    origin = provenance_of_several("reproduction", files, command_line(), deciding)
    with reserved_folder(out, "reproduction", resume=resume) as folder:
        if resume:
            require_reproduction(folder.path)
        try:
            reproduction, over_seeds = _made(folder, extent, files, seeds)
            claims = tuple(claims_of(reproduction))
            with _saying_what_is_kept(folder):
                folder.deliver(lambda place: write_reproduction(place, origin, reproduction, claims, over_seeds))
        except KeyboardInterrupt:
            say(f"Interrupted. {_kept(folder)}")
            return INTERRUPTED
    _print_result(folder, reproduction, claims, over_seeds)
    return COMPLETED


def _made(
    folder: OutputFolder, extent: Extent, files: Sequence[TextFile], seeds: int
) -> tuple[Reproduction, tuple[ClaimOverSeeds, ...]]:
    notes: list[str] = []
    try:
        with (
            finished_parts(folder.path, _identity(extent, files), notes.append) as parts,
            _saying_what_is_kept(folder),
            parts_progress() as progress,
        ):
            reproduction = reproduce(extent, progress, parts)
            return reproduction, claims_over_seeds(reproduction, seeds, progress, parts)
    finally:
        for note in notes:
            warn("note", note)


def _identity(extent: Extent, files: Sequence[TextFile]) -> Mapping[str, Any]:
    """Return what decides a reproduction's numbers; more seeds may be added to it, and any cores may make it."""
    flown = {name: value for name, value in asdict(extent).items() if name not in {"workers", "time_limit"}}
    return {
        **flown,
        "scenario_sha256": {file.path.stem: file.stamp.sha256 for file in files},
        "versions": deciding_versions(),
    }


@contextmanager
def _saying_what_is_kept(folder: OutputFolder) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        raise InputError(f"{error}\n{_kept(folder)}") from error


def _kept(folder: OutputFolder) -> str:
    return f"What was finished is kept in {folder.path}: repeat the command with --out {folder.path} --resume to go on"


def _print_result(
    folder: OutputFolder, reproduction: Reproduction, claims: Sequence[Claim], over_seeds: Sequence[ClaimOverSeeds]
) -> None:
    _print_claims(claims)
    if over_seeds:
        say()
        show(_seeds_table(over_seeds))
    say()
    say(f"Took       {reproduction.seconds:.0f} s with {reproduction.extent.workers} processes")
    say(f"Folder     {folder.path}")
    say(f"Page       {folder.path / 'reproduction.html'}")
    say(f"Recording  {further_command('view', folder.path)}")


def _print_claims(claims: Sequence[Claim]) -> None:
    """Print each claim in a few lines: five columns of sentences would be too narrow to be read."""
    for claim in claims:
        entry(claim.verdict, f"{claim.subject}: {claim.what}")
        entry("", f"target {claim.target}; measured {claim.measured}; {claim.test}")


def _seeds_table(over_seeds: Sequence[ClaimOverSeeds]) -> Table:
    table = _table(f"Over {len(over_seeds[0].by_seed)} seeds", "met", "missed", "undecided", "not met at seed")
    for each in over_seeds:
        counts = (str(each.counts[verdict]) for verdict in ("met", "missed", "undecided"))
        table.add_row(each.claim.subject, *counts, ", ".join(map(str, each.missed_at)))
    return table


def _table(*titles: str) -> Table:
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for title in titles:
        table.add_column(title)
    return table
