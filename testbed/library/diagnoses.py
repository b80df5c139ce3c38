"""Diagnosing measured records: what the model is missing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from threadpoolctl import threadpool_limits

from testbed.arrays import Matrix3
from testbed.assembly.description import write_mjcf, write_urdf
from testbed.assembly.extension import write_extended
from testbed.diagnosis.findings import Addition, additions, doubt_words, noise_notices
from testbed.diagnosis.keeping import Store, keeping
from testbed.diagnosis.location import ResidualSegment, located
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.result import result_of
from testbed.diagnosis.run_agreement import Agreement, agreements
from testbed.diagnosis.run_residuals import residuals_of
from testbed.diagnosis.state import Diagnosis, Verdict
from testbed.dynamics.inertia import inertia_of
from testbed.effects.contract import Extension
from testbed.errors import InputError
from testbed.library.arguments import AN_INSTANCE, AnyPath, GivenScenario, Switch, checked, give
from testbed.library.notebook import Shown
from testbed.library.prepared_records import PreparedRecords, Progress, prepared_records, silent
from testbed.library.records import GivenRecords
from testbed.library.saving import Saved
from testbed.next_experiment.proposal import Proposal, proposal_of
from testbed.outputs.diagnosis_folder import extensions_of, write_diagnosis, write_recording_of
from testbed.recording.notebook import notebook_viewer
from testbed.report.diagnosis.next import no_design_words, same_inertia_words
from testbed.report.diagnosis.page import diagnosis_page
from testbed.report.diagnosis.verdict import diagnosis_verdict, disagreement_words
from testbed.report.frame.blocks import Page
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd

    from testbed.recording.notebook import Viewer

GivenStore = Annotated[Store, AN_INSTANCE, give("a store with the methods get and put, or None")]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class DiagnosisResult(Shown, Saved):
    """What the model is missing.

    Attributes:
        prepared: scenario and records.
        state: all that the diagnosis found.
        places: where the residual of the nominal model is more than noise.
        agreements: of the runs on what was added.
        next_flight: what to fly next; None where nothing is ambiguous, or where it was not asked for.
        why_no_flight: why there is no next flight although explanations remain that these data do not tell apart.
    """

    prepared: PreparedRecords
    state: Diagnosis
    places: tuple[ResidualSegment, ...]
    agreements: tuple[Agreement, ...]
    next_flight: Proposal | None
    why_no_flight: tuple[str, ...]

    @property
    def verdict(self) -> Verdict | None:
        """`none`, `named`, `ambiguous` or `unexplained`; None of a diagnosis that was interrupted."""
        return self.state.verdict

    @property
    def steps(self) -> tuple[Addition, ...]:
        """The effects that were added to the model, in order, with parameters, probability and equivalence class."""
        return additions(self.state)

    @property
    def probabilities(self) -> Mapping[str, float]:
        """Of `none`, of each effect that is in question, and of something `unknown`."""
        return self.state.probabilities

    @property
    def notices(self) -> tuple[str, ...]:
        """What a reader has to know of records and result."""
        return *self.prepared.notices, *self.closing_notices

    @property
    def design_interrupted(self) -> bool:
        """Whether Ctrl-C came while the next flight was designed: all else is there."""
        return _INTERRUPTED in self.why_no_flight

    @property
    def closing_notices(self) -> tuple[str, ...]:
        """Those notices that the diagnosis itself gives rise to."""
        return (
            *self.state.notices,
            *noise_notices(self.state),
            *model_notices(self.state),
            *doubt_words(self.state),
            *disagreement_words(self.state, self.agreements),
            *self.why_no_flight,
        )

    @property
    def result(self) -> dict[str, Any]:
        """What diagnosis.json holds, without provenance, model and next flight."""
        return result_of(self.state, self.places, self.notices, self.agreements)

    @property
    def extended_model(self) -> ExtendedModel | None:
        """The nominal model with the effects that were found; None of a platform that cannot be flown.

        Raises:
            InputError: an effect cannot be built into this model.
        """
        scenario = self.prepared.scenario
        if not isinstance(scenario, Scenario):
            return None
        extensions = tuple(extensions_of(scenario, self.state))
        return ExtendedModel(scenario=scenario, extensions=extensions, inertia=inertia_of(self.state.model.theta))

    def __str__(self) -> str:
        """Return the verdict and the sentence that explains it."""
        return f"Diagnosis against {self.prepared.scenario.name}: {self.verdict}. {diagnosis_verdict(self.state).text}"

    def to_pandas(self) -> pd.DataFrame:
        """Return how probable each explanation is: a row for each, the most probable one first."""
        import pandas as pd  # noqa: PLC0415 - an optional extra

        rows = sorted(self.probabilities.items(), key=lambda item: -item[1])
        return pd.DataFrame(rows, columns=["explanation", "probability"]).set_index("explanation")

    def write(self, folder: Path, command: str) -> tuple[str, ...]:
        """Write the files of a diagnosis, as in `Saved`."""
        scenario = self.prepared.scenario
        return write_diagnosis(
            folder,
            scenario.file,
            self.prepared.origin.with_command(command),
            scenario,
            self.state,
            self.places,
            self.agreements,
            self.notices,
            self.next_flight,
        )

    def viewer(self, *, height: int = 600) -> Viewer:
        """Return the recording in the rerun viewer, for the last line of a notebook's cell; see `Run.viewer`.

        Args:
            height: pixels; it is as wide as the cell.

        Raises:
            InputError: rerun-notebook is not installed (`pip install 'testbed[notebook]'`).
        """
        origin, scenario = self.prepared.origin, self.prepared.scenario
        return notebook_viewer(lambda path: write_recording_of(path, origin, scenario, self.state), height)

    def _page(self) -> Page:
        return diagnosis_page(
            self.state,
            self.places,
            residuals_of(self.state),
            self.agreements,
            self.next_flight,
            self.prepared.origin.listed,
            self.result,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class ExtendedModel:
    """The nominal model with the effects that a diagnosis found.

    Attributes:
        scenario: the nominal one.
        extensions: what each effect adds to the platform and changes in the scenario.
        inertia: J of the whole platform as estimated together with the effects, shape (3, 3), kg·m², body axes.
    """

    scenario: Scenario
    extensions: tuple[Extension, ...]
    inertia: Matrix3

    @checked
    def save(self, folder: AnyPath) -> Path:
        """Write platform.xml and scenario.toml, which fly as they stand, and return the scenario's path.

        Raises:
            InputError: an effect cannot be built into this model.
        """
        return write_extended(self.scenario, self.extensions, self.inertia, Path(folder))

    @checked
    def to_mjcf(self, path: AnyPath) -> Path:
        """Write the platform with its estimated inertia as MJCF; `save` writes it with the effects too.

        Args:
            path: of the file; one that is there is replaced.

        Raises:
            InputError: no body has this inertia, or the file cannot be written.
        """
        return write_mjcf(self.scenario, self.inertia, Path(path))

    @checked
    def to_urdf(self, path: AnyPath) -> Path:
        """Write the platform with its estimated inertia as URDF, which knows neither motors nor the effects.

        A link stands for the bus, each gimbal and each rotor; mass and inertia are those of the whole platform.

        Args:
            path: of the file; one that is there is replaced.

        Raises:
            InputError: no body has this inertia, or the file cannot be written.
        """
        return write_urdf(self.scenario, self.inertia, Path(path))


@checked
def diagnose(
    scenario: GivenScenario,
    records: GivenRecords,
    *,
    progress: Progress = silent,
    keep: GivenStore | None = None,
    propose: Switch = True,
    reference: GivenRecords | None = None,
) -> DiagnosisResult:
    """Find where a nominal model and measured records disagree, and name the effects that explain it.

    Args:
        scenario: the nominal model.
        records: two runs or more; of three and more, some are held out to verify on.
        reference: healthy records of the same platform, three or more: what they show is taken into the nominal model,
            as uncertain as it differs between them, so that only what is new gets a name.
        progress: called with what is being tested.
        keep: keeps finished parts of the work, so that an interrupted diagnosis goes on where it was.
        propose: whether to design the next flight where explanations remain that these data do not tell apart.

    Raises:
        InputError: the records cannot be used, or no model explains them.

    Example:
        >>> import testbed as tb
        >>> scenario = tb.read_scenario("diagnose")
        >>> records = tb.Records(tuple(tb.fly(scenario, seed=seed).record for seed in (1, 2)))
        >>> tb.diagnose(scenario, records).verdict
        'none'
    """
    # Many small problems: shared among threads they wait for one another, and take three times as long and more.
    with threadpool_limits(limits=1, user_api="blas"):
        with nullcontext() if keep is None or reference is None else keeping(keep):
            made = prepared_records(scenario, records, reference, progress)
        with nullcontext() if keep is None else keeping(keep):
            first, last = _first_and_last(made.stages(progress))
        return concluded(made, last, located(first.runs, first.baseline), progress, propose=propose)


def concluded(
    made: PreparedRecords,
    state: Diagnosis,
    places: Sequence[ResidualSegment],
    progress: Progress = silent,
    *,
    propose: bool = True,
) -> DiagnosisResult:
    """Return the result of a diagnosis.

    Args:
        made: scenario and records.
        state: what the last stage found, complete or not.
        places: where the residual of the nominal model is more than noise.
        progress: called with what is being tested.
        propose: whether to design the next flight.
    """
    proposal, why_none = _next_flight(made.scenario, state, progress) if propose else (None, ())
    return DiagnosisResult(
        prepared=made,
        state=state,
        places=tuple(places),
        agreements=tuple(agreements(state)),
        next_flight=proposal,
        why_no_flight=why_none,
    )


_INTERRUPTED = "no next flight: its design was interrupted"


def _first_and_last(stages: Iterator[Diagnosis]) -> tuple[Diagnosis, Diagnosis]:
    first = last = next(stages)
    for state in stages:
        first, last = state if state.begins_again(last) else first, state
    return first, last


def _next_flight(
    scenario: BodyScenario, state: Diagnosis, progress: Progress
) -> tuple[Proposal | None, tuple[str, ...]]:
    """Return what to fly next, and notices of what remains indistinguishable without it; Ctrl-C leaves it out."""
    if not state.complete:
        return None, ()
    if not isinstance(scenario, Scenario) or not state.runs.driven_by_momentum:
        return None, (*no_design_words(state), *same_inertia_words(state))
    try:
        return proposal_of(state, scenario, progress), ()
    except KeyboardInterrupt:
        return None, (_INTERRUPTED,)
    except InputError as error:  # a motion that leaves the finite numbers: the diagnosis stands
        return None, (f"no next flight: {error}",)
