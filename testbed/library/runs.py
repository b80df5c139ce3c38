"""Designing a maneuver and flying it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from testbed.arrays import Theta
from testbed.assembly.dispersion import dispersed
from testbed.assembly.engine import engine_of
from testbed.assembly.platform import nominal_platform
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.errors import InputError
from testbed.estimation.estimate import Estimate
from testbed.experiment.conduct import conduct
from testbed.experiment.experiment import Experiment
from testbed.experiment.planning import Plan, beyond_envelope, design_seed, plan_maneuver
from testbed.experiment.result import result_of
from testbed.library.arguments import AN_INSTANCE, AnyPath, GivenScenario, Seed, Switch, checked, give
from testbed.library.notebook import Shown, parameter_frame
from testbed.library.saving import Saved
from testbed.library.scenarios import naming, require_flyable
from testbed.maneuver.design import Start
from testbed.outputs.design_folder import maneuver_table, write_design
from testbed.outputs.provenance import Provenance, provenance
from testbed.outputs.run_folder import write_run, write_run_recording
from testbed.recording.notebook import notebook_viewer
from testbed.records.record import Record
from testbed.report.frame.blocks import Page
from testbed.report.run import run_page, run_verdict
from testbed.scenario.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd

    from testbed.recording.notebook import Viewer

DesignProgress = Callable[[Start], None]


def silent(_: Start) -> None:
    """Report no start."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Maneuver(Shown, Saved):
    """A maneuver for a scenario's platform, and how it was designed.

    Attributes:
        scenario: that it was planned for.
        plan: the reference, and its design; without one where the scenario gives the maneuver.
        origin: what made it.
    """

    scenario: Scenario
    plan: Plan
    origin: Provenance

    def __str__(self) -> str:
        """Return what was designed and how good it is."""
        design, duration = self.plan.design, self.plan.maneuver.duration
        if design is None:
            return f"Maneuver of {self.scenario.name}, {duration:g} s, as the scenario gives it."
        figures = design.information
        return (
            f"{design.criterion}-optimal maneuver of {self.scenario.name} in {design.parametrization} space, "
            f"{duration:g} s: determinant of the information {figures.determinant:.3g}, trace of its inverse "
            f"{figures.trace_inverse:.3g}, smallest eigenvalue {figures.min_eigenvalue:.3g}."
        )

    @property
    def notices(self) -> tuple[str, ...]:
        """What a reader has to know of it: that no actuators of the platform can follow it."""
        words = beyond_envelope(self.scenario, nominal_platform(self.scenario), self.plan.maneuver)
        return (words,) if words else ()

    def to_pandas(self) -> pd.DataFrame:
        """Return the reference at 100 samples a second: `time_s` and a column for each signal, SI."""
        return maneuver_table(self.plan.maneuver, self.scenario).to_pandas()

    def write(self, folder: Path, command: str) -> tuple[str, ...]:
        """Write the files of a design, as in `Saved`; there are none where the scenario gives the maneuver."""
        if self.plan.design is None:
            raise InputError(f"{self.scenario.name}: the scenario gives its maneuver; there is no design to write")
        origin = self.origin.with_command(command)
        write_design(folder, self.scenario.file, origin, self.scenario, self.plan.design)
        return ()


GivenManeuver = Annotated[Maneuver, AN_INSTANCE, give("a maneuver: tb.design(scenario) makes one; or None")]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run(Shown, Saved):
    """One flight of a scenario and what was estimated from it.

    Attributes:
        scenario: as it was asked for; what is flown may be dispersed about it.
        experiment: all that the run produced.
        origin: what made it.
    """

    scenario: Scenario
    experiment: Experiment
    origin: Provenance

    @property
    def record(self) -> Record:
        """Telemetry, and what only the simulation knows."""
        return self.experiment.flown.record

    @property
    def estimates(self) -> Mapping[str, Estimate]:
        """Each estimator's answer, by its name; empty where the flight diverged."""
        estimation = self.experiment.estimation
        return {} if estimation is None else estimation.by_name

    @property
    def bound(self) -> Theta | None:
        """Standard deviations of the Cramér-Rao bound of the motion as flown, shape (6,), kg·m²; None without one."""
        return None if self.experiment.estimation is None else self.experiment.estimation.bound_std

    @property
    def truth(self) -> Theta:
        """θ of the platform that flew, shape (6,), kg·m²."""
        return theta_of(self.experiment.truth.inertia)

    @property
    def verdict(self) -> str:
        """The run's verdict in a sentence."""
        return run_verdict(self.experiment).text

    @property
    def result(self) -> dict[str, Any]:
        """What result.json holds, without provenance."""
        return result_of(self.experiment)

    def __str__(self) -> str:
        """Return the run's verdict."""
        return f"Run of {self.scenario.name}, seed {self.experiment.seed}. {self.verdict}"

    def to_pandas(self) -> pd.DataFrame:
        """Return truth, nominal, bound, and estimates with their standard deviations: a row a parameter, kg·m²."""
        columns: dict[str, Theta] = {"true": self.truth, "nominal": theta_of(self.experiment.nominal.inertia)}
        if self.bound is not None:
            columns["bound_std"] = self.bound
        for name, estimate in self.estimates.items():
            columns |= {name: estimate.theta, f"{name}_std": estimate.std}
        return parameter_frame(columns, PARAMETER_NAMES)

    def write(self, folder: Path, command: str) -> tuple[str, ...]:
        """Write the files of a run, as in `Saved`."""
        write_run(folder, self.scenario.file, self.origin.with_command(command), self.experiment)
        return ()

    @checked
    def show(self, folder: AnyPath, *, web: Switch = False) -> None:
        """Write the run folder and open its recording in the rerun viewer, until that is closed.

        Args:
            folder: new or empty.
            web: whether to serve the viewer to a browser on this machine instead.
        """
        from testbed.recording.viewer import open_viewer  # noqa: PLC0415 - the viewer is wanted by few runs

        open_viewer(self.save(folder) / "recording.rrd", web=web)

    def viewer(self, *, height: int = 600) -> Viewer:
        """Return the recording in the rerun viewer, for the last line of a notebook's cell.

        The page gets the viewer from this process, on loopback. Where its browser is on another machine, set
        `RERUN_NOTEBOOK_ASSET` before the first viewer, as rerun-notebook describes.

        Args:
            height: pixels; it is as wide as the cell.

        Raises:
            InputError: rerun-notebook is not installed (`pip install 'testbed[notebook]'`).
        """
        return notebook_viewer(lambda path: write_run_recording(path, self.origin, self.experiment), height)

    def _page(self) -> Page:
        return run_page(self.experiment, self.origin.listed, {})


@checked
def design(scenario: GivenScenario, *, seed: Seed | None = None, progress: DesignProgress = silent) -> Maneuver:
    """Design the maneuver of a scenario, or take the one that it gives.

    Args:
        scenario: with a [maneuver].
        seed: of the design's starts; the scenario's where None.
        progress: called with each start as it ends.

    Raises:
        InputError: the limits cannot be met, or the platform cannot be built or flown.

    Example:
        >>> import testbed as tb
        >>> maneuver = tb.design(tb.read_scenario("basic"))
        >>> maneuver.plan.maneuver.duration
        5.0
    """
    flown = require_flyable(scenario)
    origin = provenance(flown, flown.file, "testbed.design", deciding={"seed": str(design_seed(flown, seed))})
    with naming(flown):
        plan = plan_maneuver(flown, nominal_platform(flown), progress, seed)
    return Maneuver(scenario=flown, plan=plan, origin=origin)


@checked
def fly(
    scenario: GivenScenario,
    maneuver: GivenManeuver | None = None,
    *,
    seed: Seed | None = None,
    draw: Switch = False,
    progress: DesignProgress = silent,
) -> Run:
    """Fly a scenario in the closed loop and estimate the inertia from what it sent.

    Args:
        scenario: to fly.
        maneuver: as from `design`; planned first where None.
        seed: of all sensor noise; the scenario's where None. The same seed gives the same record, bit for bit.
        draw: whether truth, start and gyro are drawn from the scenario's [dispersion] with this seed.
        progress: called with each start of a design as it ends.

    Raises:
        InputError: the platform cannot be built, or the maneuver cannot be designed.

    Example:
        >>> import testbed as tb
        >>> run = tb.fly(tb.read_scenario("basic"), seed=1)
        >>> run.estimates["output_error"].theta.shape
        (6,)
    """
    flown = require_flyable(scenario)
    seed = flown.seed if seed is None else seed
    plan = None if maneuver is None else maneuver.plan
    with naming(flown):
        deciding = {"seed": str(seed), "dispersed": str(draw), "engine": engine_of(flown, many=False)}
        origin = provenance(flown, flown.file, "testbed.fly", deciding=deciding)
        drawn = dispersed(flown, seed) if draw else None
        experiment = conduct(flown, seed, progress, plan=plan, flown_scenario=drawn)
    return Run(scenario=flown, experiment=experiment, origin=origin)
