"""testbed diagnose: where model and measured data disagree, and which named effect is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.progress import Progress, SpinnerColumn, TimeElapsedColumn
from rich.text import Text

from testbed.assembly.extension import SCENARIO
from testbed.assembly.platform import Body, nominal_body
from testbed.cli.console import command_line, console, description_column, entry, say, show, terminal, warn
from testbed.cli.diagnose_tables import candidates_table, detectable_table, inertia_table, places_table
from testbed.cli.failures import COMPLETED, INTERRUPTED, naming
from testbed.delivery.diagnosis_folder import NEXT, WRITTEN, write_diagnosis
from testbed.delivery.diagnosis_parts import PARTS, KeptParts, kept_parts
from testbed.delivery.folder import OutputFolder, reserved_folder
from testbed.delivery.provenance import Provenance, provenance
from testbed.diagnosis.findings import Addition, addition_of, first_screening, masked, noise_notices
from testbed.diagnosis.keeping import keeping
from testbed.diagnosis.location import Place, located
from testbed.diagnosis.plausibility import require_explicable
from testbed.diagnosis.reading import DataSet, data_set_of
from testbed.diagnosis.result import unmasked_needs
from testbed.diagnosis.run_agreement import Agreement, agreements
from testbed.diagnosis.state import Diagnosis, Step
from testbed.diagnosis.workflow import diagnosed
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, READING_EFFECTS
from testbed.errors import InputError
from testbed.files import TextFile
from testbed.records.reading import read_data_set
from testbed.records.record import Record
from testbed.report.diagnosis_misfit import (
    MEANING,
    gimbals_words,
    limit_words,
    misfit_change_words,
    misfit_words,
)
from testbed.report.diagnosis_next import distance_words, flight_words, no_gimbals_words, pair_words
from testbed.report.diagnosis_ranking import on_the_noise
from testbed.report.diagnosis_verdict import (
    addition_words,
    agreement_words,
    diagnosis_verdict,
    disagreement_words,
    effect_name,
    gap_words,
    shape_words,
    share_words,
)
from testbed.report.wording import chance_words, listed
from testbed.scenario.body import BodyScenario
from testbed.scenario.reader import body_scenario_of, scenario_file
from testbed.scenario.scenario import Scenario
from testbed.separation.proposal import Proposal, proposal_of

_PAIRS_SHOWN = 3


def diagnose_records(path: Path, data: Path, out: Path | None, *, resume: bool) -> int:
    """Diagnose the records of a folder against a nominal scenario, print and write what was found.

    Args:
        path: of the scenario.
        data: folder of records.
        out: new or empty folder; None for a fresh one.
        resume: whether to go on with a diagnosis that was interrupted, in its folder.

    Returns:
        The exit code; Ctrl-C keeps what was found so far.

    Raises:
        InputError: scenario, records or output folder cannot be used.
    """
    file = scenario_file(path)
    scenario = body_scenario_of(file)
    if resume and out is None:
        raise InputError("--resume goes on with a diagnosis that was interrupted: name its folder with --out")
    with reserved_folder(out, f"{scenario.name}-diagnosis", resume=resume) as folder:
        return _diagnose(file, scenario, data, folder, resume=resume)


def _diagnose(file: TextFile, scenario: BodyScenario, data: Path, folder: OutputFolder, *, resume: bool) -> int:
    with naming(file.path):
        nominal = nominal_body(scenario)
    records = read_data_set(data)
    origin = provenance(scenario, file, command_line(), data=[stamp for record in records for stamp in record.files])
    with kept_parts(folder, origin, resume=resume) as parts:
        return _diagnose_parts(file, scenario, nominal, records, origin, folder, parts)


def _diagnose_parts(
    file: TextFile,
    scenario: BodyScenario,
    nominal: Body,
    records: Sequence[Record],
    origin: Provenance,
    folder: OutputFolder,
    parts: KeptParts,
) -> int:
    data_set = data_set_of(records, scenario, nominal)
    known = _notices(data_set)
    _tell_data(data_set, (*known, *_parts_notices(parts)))
    told = _Told()
    try:
        with _progress() as progress, keeping(parts):
            stages = diagnosed(
                data_set.runs,
                data_set.heldout,
                EFFECTS,
                theta_of(nominal.inertia),
                progress,
                READING_EFFECTS,
                alone=data_set.alone,
            )
            for diagnosis in stages:
                told.tell(diagnosis)
    except KeyboardInterrupt:
        pass
    if told.last is None:
        what = _again(folder) if parts.parts else "nothing was written."
        say(f"Interrupted before anything was found; {what}")
        return INTERRUPTED
    if told.last.complete:
        require_explicable(told.last.runs, told.last.gap_before.fit, told.last.gap.fit)
    proposal, why_none = _next_flight(told.last, scenario)
    agreed = agreements(told.last)
    _tell_end(told.last, agreed)
    at_the_end = (*noise_notices(told.last), *disagreement_words(told.last, agreed), *why_none)
    notices = (*known, *at_the_end)
    last, places = told.last, told.places
    said = folder.deliver(
        lambda place: write_diagnosis(place, file, origin, scenario, last, places, agreed, notices, proposal),
        instead_of=(*WRITTEN, PARTS) if last.complete else WRITTEN,
    )
    for notice in (*at_the_end, *said):
        warn("note", notice)
    _tell_next(folder.path, proposal)
    _tell_folder(folder.path)
    if last.complete:
        return COMPLETED
    say(f"Interrupted; {_again(folder)}")
    return INTERRUPTED


def _again(folder: OutputFolder) -> str:
    return f"what was worked out is kept: repeat the command with --out {folder.path} --resume to go on."


def _parts_notices(parts: KeptParts) -> Iterator[str]:
    if parts.parts:
        yield f"goes on with {len(parts.parts)} parts that are kept in {parts.path}"
    if parts.damaged:
        yield f"{parts.path}: {parts.damaged} of its lines are damaged; what they held is worked out again"


def _next_flight(diagnosis: Diagnosis, scenario: BodyScenario) -> tuple[Proposal | None, tuple[str, ...]]:
    """Return what to fly next, and what there is to say where look-alikes remain without it; Ctrl-C leaves it out."""
    if not diagnosis.complete:
        return None, ()
    if not isinstance(scenario, Scenario) or not diagnosis.runs.driven_by_momentum:
        return None, tuple(no_gimbals_words(diagnosis))
    try:
        with _progress() as progress:
            return proposal_of(diagnosis, scenario, progress), ()
    except KeyboardInterrupt:
        return None, ("no next flight: its design was interrupted",)


class _Told:
    """Prints what each stage of a diagnosis adds to what was told before."""

    def __init__(self) -> None:
        self.last: Diagnosis | None = None
        self.places: tuple[Place, ...] = ()

    def tell(self, diagnosis: Diagnosis) -> None:
        """Print what is new."""
        before, self.last = self.last, diagnosis
        if before is None:
            self.places = located(diagnosis.runs, diagnosis.baseline)
            _tell_gap(diagnosis, self.places)
        if first_screening(diagnosis) is not None and (before is None or first_screening(before) is None):
            say()
            show(detectable_table(diagnosis))
        for step in diagnosis.steps[len(before.steps) if before else 0 :]:
            _tell_step(diagnosis, step)
        if diagnosis.complete:
            _tell_rest(diagnosis)


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Show what is being done, and for how long, on standard error."""
    columns = (SpinnerColumn(), description_column(), TimeElapsedColumn())
    with Progress(*columns, console=terminal, transient=True, disable=not terminal.is_terminal) as bars:
        task = bars.add_task("Reading")
        yield lambda what: bars.update(task, description=f"Testing {what}")


def _notices(data_set: DataSet) -> tuple[str, ...]:
    """Return what a reader has to know of the records."""
    if data_set.heldout is not None:
        return data_set.notices
    if data_set.alone:
        return *data_set.notices, "a single run gets no name: nothing could verify it; fly another one"
    return *data_set.notices, "no run is held out: what is found here is verified on none; fly another run"


def _tell_data(data_set: DataSet, notices: Sequence[str]) -> None:
    fit, held_out = data_set.fit_records, data_set.heldout_records
    entry("Runs", f"fitted: {', '.join(fit)}; held out: {', '.join(held_out) or 'none'}")
    for notice in notices:
        warn("note", notice)


def _tell_gap(diagnosis: Diagnosis, places: Sequence[Place]) -> None:
    entry("Misfit", f"{misfit_words(diagnosis.gap_before)}")
    entry("", "of the nominal model, its inertia and the initial rates re-estimated:")
    entry("", MEANING)
    entry("", limit_words(diagnosis.gap_before))
    entry("Gap", f"{gap_words(diagnosis.gap_before)}, rms of all channels in sigma of each; noise alone is 1")
    if diagnosis.scatter:
        names = listed(effect_name(each.effect, each.component) for each in diagnosis.scatter)
        entry("Noise", f"in the one that the samples show ({names}) the misfit is {misfit_words(diagnosis.gap)},")
        entry("", f"the gap {gap_words(diagnosis.gap)}")
    if places:
        say()
        show(places_table(places))


def _tell_step(diagnosis: Diagnosis, step: Step) -> None:
    say()
    show(candidates_table(step.screening))
    say()
    _tell_addition(addition_of(diagnosis, step))
    entry("Misfit", misfit_change_words(step.before, step.after))
    if gimbals := gimbals_words(step.before, step.after):
        entry("", gimbals)
    entry("Gap", f"{gap_words(step.before)} -> {gap_words(step.after)}")


def _tell_addition(addition: Addition) -> None:
    entry("Added", effect_name(addition.effect, addition.component))
    for line in addition_words(addition):
        entry("", line)


def _tell_rest(diagnosis: Diagnosis) -> None:
    if diagnosis.remaining is not None and not diagnosis.steps:
        say()
        show(candidates_table(diagnosis.remaining, on_the_noise(diagnosis)))
    for scatter in diagnosis.scatter:
        say()
        _tell_addition(addition_of(diagnosis, scatter))
    hidden = masked(diagnosis)
    if hidden:
        say()
    for placed, by in hidden:
        entry("Untestable", f"{effect_name(placed.effect, placed.component)}: needs {unmasked_needs(by)}")
    if diagnosis.latent is not None:
        say()
        entry("Left over", f"a torque that no effect names: {chance_words(diagnosis.latent.p_value)}")
        entry("", shape_words(diagnosis).strip() or "no torque of a known shape either")
        if share := share_words(diagnosis):
            entry("", share)


def _tell_end(diagnosis: Diagnosis, agreed: Sequence[Agreement]) -> None:
    say()
    for each in agreed:
        entry("Run by run", f"{effect_name(each.placed.effect, each.placed.component)}: {agreement_words(each)}")
    if agreed:
        say()
    show(inertia_table(diagnosis))
    say()
    verdict = diagnosis_verdict(diagnosis)
    colour = {"good": "green", "warn": "yellow", "bad": "red"}.get(verdict.tone, "default")
    console.print(Text.assemble(("Verdict", colour), f"    {diagnosis.verdict or 'not reached'}"))
    entry("", verdict.text)


def _tell_next(folder: Path, proposal: Proposal | None) -> None:
    if proposal is None:
        return
    say()
    entry("Next", flight_words(proposal))
    for separation in proposal.separations[:_PAIRS_SHOWN]:
        entry("", f"{pair_words(separation)}: {distance_words(separation)}")
    if proposal.flight is not None:
        say(f"           testbed run {folder / NEXT / SCENARIO}")


def _tell_folder(folder: Path) -> None:
    say()
    say(f"Folder     {folder}")
    say(f"Report     {folder / 'report.html'}")
    say(f"Recording  testbed view {folder}")
