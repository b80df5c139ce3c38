"""testbed run: one scenario, from design to recording."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from testbed.assembly.dispersion import dispersed
from testbed.cli.alignments import print_alignments
from testbed.cli.console import command_line, design_progress, say, show
from testbed.cli.failures import COMPLETED, DIVERGED, naming
from testbed.cli.notices import print_notices, print_verdict
from testbed.cli.tables import design_lines, flight_lines, result_table
from testbed.delivery.folder import reserved_folder
from testbed.delivery.provenance import provenance
from testbed.delivery.run_folder import write_run
from testbed.experiment.conduct import conduct
from testbed.experiment.experiment import Experiment
from testbed.experiment.planning import starts_of
from testbed.report.run import run_notices, run_verdict
from testbed.scenario.reader import scenario_file, scenario_of


def run_scenario(path: Path, out: Path | None, seed: int | None, *, drawn: bool, view: bool) -> int:
    """Fly a scenario, write its run folder, print its result; returns the exit code.

    Args:
        path: of the scenario.
        out: the run folder.
        seed: of all noise; the scenario's where None.
        drawn: whether truth, start and gyro are what a campaign's run with this seed draws.
        view: whether to open the recording.

    Raises:
        InputError: the scenario, its limits or the output folder cannot be used.
    """
    file = scenario_file(path)
    scenario = scenario_of(file)
    seed = scenario.seed if seed is None else seed
    origin = provenance(scenario, file, command_line(), deciding={"seed": str(seed), "dispersed": str(drawn)})
    with reserved_folder(out, scenario.name) as folder:
        with naming(path), design_progress(starts_of(scenario)) as report:
            experiment = conduct(scenario, seed, report, flown_scenario=dispersed(scenario, seed) if drawn else None)
        folder.deliver(lambda place: write_run(place, file, origin, experiment))
    _print_result(experiment, folder.path)
    if view:
        from testbed.recording.viewer import open_viewer  # noqa: PLC0415 - the viewer is wanted by few runs

        open_viewer(folder.path / "recording.rrd", web=False)
    return COMPLETED if experiment.outcome == "completed" else DIVERGED


def _print_result(experiment: Experiment, folder: Path) -> None:
    if experiment.estimation is not None:
        show(result_table(experiment))
        say()
    if experiment.aligning is not None:
        print_alignments(experiment.aligning)
    for line in (*design_lines(experiment.plan.design), *flight_lines(experiment.flown)):
        say(line)
    say()
    print_verdict(run_verdict(experiment))
    print_notices(run_notices(experiment))
    say()
    say(f"Folder     {folder}")
    say(f"Report     {folder / 'report.html'}")
    say(f"Recording  {_this_command()} view {folder}  (or view --web: in the browser)")


def _this_command() -> str:
    """Return how this person can call testbed: by its name where that is on the path, else as it was called."""
    return "testbed" if shutil.which("testbed") else sys.argv[0]
