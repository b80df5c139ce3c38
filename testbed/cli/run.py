"""testbed run: one scenario, from design to recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbed.cli.alignments import print_alignments
from testbed.cli.console import command_line, design_progress, further_command, line, print_as_json, say, show, warn
from testbed.cli.failures import COMPLETED, DIVERGED
from testbed.cli.notices import print_notices, print_verdict
from testbed.cli.options import changed_flight, print_folder
from testbed.cli.tables import design_lines, flight_lines, result_table
from testbed.experiment.experiment import Experiment
from testbed.experiment.planning import starts_of
from testbed.library.runs import fly
from testbed.outputs.folder import reserved_folder
from testbed.report.run import run_notices, run_verdict


def run_scenario(
    source: str, changes: Sequence[str], out: Path | None, seed: int | None, *, drawn: bool, view: bool
) -> int:
    """Fly a scenario, write its run folder, print its result; returns the exit code.

    Args:
        source: path of the scenario, or name of a shipped one.
        changes: of the scenario, KEY=VALUE each.
        out: the run folder.
        seed: of all noise; the scenario's where None.
        drawn: whether truth, start and gyro are what a campaign's run with this seed draws.
        view: whether to open the recording.

    Raises:
        InputError: the scenario, its limits or the output folder cannot be used.
    """
    scenario = changed_flight(source, changes)
    if drawn and scenario.dispersion is None:
        warn("note", "the scenario has no [dispersion]: with --dispersed it flies as without")
    with reserved_folder(out, scenario.name) as folder:
        with design_progress(starts_of(scenario)) as report:
            run = fly(scenario, seed=seed, draw=drawn, progress=report)
        folder.deliver(lambda place: run.write(place, command_line()))
    _print_result(run.experiment, folder.path)
    print_as_json(folder.path / "result.json")
    if view:
        from testbed.recording.viewer import open_viewer  # noqa: PLC0415 - the viewer is wanted by few runs

        open_viewer(folder.path / "recording.rrd", web=False)
    return COMPLETED if run.experiment.outcome == "completed" else DIVERGED


def _print_result(experiment: Experiment, folder: Path) -> None:
    if experiment.estimation is not None:
        show(result_table(experiment))
        say()
    if experiment.aligning is not None:
        print_alignments(experiment.aligning)
    for text in (*design_lines(experiment.plan.design), *flight_lines(experiment.flown)):
        line(text)
    say()
    print_verdict(run_verdict(experiment))
    print_notices(run_notices(experiment))
    say()
    print_folder(folder)
    line(f"Recording  {further_command('view', folder)}  (or view --web: in the browser)")
