"""testbed diagnose: where model and measured data disagree, and which named effect is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import filterfalse
from pathlib import Path

from rich.progress import SpinnerColumn, TimeElapsedColumn
from rich.text import Text
from threadpoolctl import threadpool_limits

from testbed.assembly.extension import SCENARIO
from testbed.cli.console import (
    Bars,
    command_line,
    console,
    description_column,
    entries,
    entry,
    further_command,
    print_as_json,
    say,
    say_interrupted,
    show,
    warn,
)
from testbed.cli.diagnose_tables import (
    candidates_table,
    detectable_table,
    inertia_table,
    places_table,
    sizes_table,
)
from testbed.cli.failures import COMPLETED, INTERRUPTED
from testbed.cli.options import changed_scenario, print_folder, require_folder
from testbed.diagnosis.detectable import confounded, first_screening
from testbed.diagnosis.findings import Addition, addition_of
from testbed.diagnosis.keeping import keeping
from testbed.diagnosis.location import ResidualSegment, located
from testbed.diagnosis.reading import DataSet
from testbed.diagnosis.result import unconfounded_needs
from testbed.diagnosis.state import Diagnosis, Step
from testbed.library.diagnoses import DiagnosisResult, concluded
from testbed.library.prepared_records import origin_of, prepared_records
from testbed.library.records import Records, read_records
from testbed.next_experiment.proposal import Proposal
from testbed.outputs.diagnosis_folder import NEXT, WRITTEN
from testbed.outputs.diagnosis_parts import PARTS, KeptParts, kept_parts
from testbed.outputs.folder import OutputFolder, reserved_folder
from testbed.report.diagnosis.misfit import (
    MEANING,
    gimbals_words,
    in_other_noise,
    limit_words,
    misfit_change_words,
    misfit_words,
)
from testbed.report.diagnosis.next import distance_words, flight_words, pair_words
from testbed.report.diagnosis.ranking import on_the_noise
from testbed.report.diagnosis.sizes import confounded_words, lacking
from testbed.report.diagnosis.verdict import (
    addition_words,
    agreement_words,
    diagnosis_verdict,
    effect_name,
    gap_words,
    quantity_words,
    shape_words,
    share_words,
)
from testbed.report.wording import chance_words, figures, listed
from testbed.scenario.body import BodyScenario

_PAIRS_SHOWN = 3


def diagnose_records(
    source: str, changes: Sequence[str], data: Path, out: Path | None, *, resume: bool, reference: Path | None = None
) -> int:
    """Diagnose the records of a folder against a nominal scenario, print and write what was found.

    Args:
        source: path of the scenario, or name of a shipped one.
        changes: of the scenario, KEY=VALUE each.
        data: folder of records.
        out: new or empty folder; None for a fresh one.
        resume: whether to go on with a diagnosis that was interrupted, in its folder.
        reference: folder of healthy records; None without.

    Returns:
        The exit code; Ctrl-C keeps what was found so far.

    Raises:
        InputError: scenario, records or output folder cannot be used.
    """
    scenario = changed_scenario(source, changes)
    require_folder("diagnosis", out, resume=resume)
    with reserved_folder(out, f"{scenario.name}-diagnosis", resume=resume) as folder:
        records = read_records(data)
        healthy = None if reference is None else read_records(reference)
        with (
            kept_parts(folder, origin_of(scenario, records, command_line(), healthy), resume=resume) as parts,
            threadpool_limits(limits=1, user_api="blas"),  # as in `testbed.diagnose`
        ):
            return _diagnose(scenario, records, healthy, folder, parts, resume=resume)


def _diagnose(
    scenario: BodyScenario,
    records: Records,
    healthy: Records | None,
    folder: OutputFolder,
    parts: KeptParts,
    *,
    resume: bool,
) -> int:
    resumed = tuple(_parts_notices(parts, resume=resume))  # before the healthy records add parts of their own
    if healthy is None:
        prepared = prepared_records(scenario, records)
    else:
        try:
            with _bars() as bars, keeping(parts):
                prepared = prepared_records(scenario, records, healthy, _shown_in(bars))
        except KeyboardInterrupt:
            return _found_nothing(folder, parts)
    _print_data(prepared.data, (*prepared.notices, *resumed))
    stages = _Stages()
    with suppress(KeyboardInterrupt), _bars() as bars, keeping(parts):
        for state in prepared.stages(_shown_in(bars)):
            bars.stop()  # results printed beside a bar that moves would be torn
            stages.show(state)
            bars.start()
    if stages.last is None:
        return _found_nothing(folder, parts)
    try:
        with _bars() as bars:
            result = concluded(prepared, stages.last, stages.places, _shown_in(bars))
        return _written(result, folder)
    except KeyboardInterrupt:
        if (folder.path / "diagnosis.json").exists():
            raise
        say_interrupted(f" before the folder was written; {_again(folder)}")
        return INTERRUPTED


def _written(result: DiagnosisResult, folder: OutputFolder) -> int:
    """Print what a diagnosis found and write its folder; return the exit code."""
    _print_end(result)
    whole = result.state.complete and not result.design_interrupted
    replaced = (*WRITTEN, PARTS) if whole else WRITTEN
    more = folder.deliver(lambda place: result.write(place, command_line()), instead_of=replaced)
    for notice in (*result.closing_notices, *more):
        warn("note", notice)
    _print_next(folder.path, result.next_flight)
    _print_folder(folder.path)
    print_as_json(folder.path / "diagnosis.json")
    if whole:
        return COMPLETED
    say_interrupted(f"{' while the next flight was designed' if result.design_interrupted else ''}; {_again(folder)}")
    return INTERRUPTED


def _found_nothing(folder: OutputFolder, parts: KeptParts) -> int:
    what = _again(folder) if parts.parts else "nothing was written."
    say_interrupted(f" before anything was found; {what}")
    return INTERRUPTED


def _again(folder: OutputFolder) -> str:
    return f"what was worked out is kept: repeat the command with --out {folder.path} --resume to go on."


def _parts_notices(parts: KeptParts, *, resume: bool) -> Iterator[str]:
    if resume and not parts.parts:
        yield f"--resume: {parts.path} holds nothing of an interrupted diagnosis, so that this one begins anew"
    if parts.parts:
        yield f"goes on with {len(parts.parts)} parts that are kept in {parts.path}"
    if parts.damaged:
        yield f"{parts.path}: {parts.damaged} of its lines are damaged; what they held is worked out again"


class _Stages:
    """Prints what each stage of a diagnosis adds to the one before."""

    def __init__(self) -> None:
        self.last: Diagnosis | None = None
        self.places: tuple[ResidualSegment, ...] = ()

    def show(self, diagnosis: Diagnosis) -> None:
        """Print what is new."""
        before, self.last = self.last, diagnosis
        if before is not None and diagnosis.begins_again(before):
            say()
            warn("note", f"{_why_again(before, diagnosis)}, and replaces the above")
            before = None
        if before is None:
            self.places = located(diagnosis.runs, diagnosis.baseline)
            _print_gap(diagnosis, self.places)
        if first_screening(diagnosis) is not None and (before is None or first_screening(before) is None):
            say()
            show(detectable_table(diagnosis))
            _print_untestable(diagnosis)
            if pairs := confounded_words(diagnosis):
                say()
                entry("Confounded", f"by these data: {pairs}")
        shown = {step.key for step in before.steps} if before else set()
        for step in diagnosis.steps:  # one that takes the place of a retracted one is new too
            if step.key not in shown:
                _print_step(diagnosis, step)
        if diagnosis.complete:
            _print_rest(diagnosis)


def _why_again(before: Diagnosis, now: Diagnosis) -> str:
    moved = [name for name in now.runs.record_names if name not in before.runs.record_names]
    if not moved:
        return "trims differ from record to record: what follows is with one of each"
    return f"{listed(moved)}, held out so far, shows what the fitted runs do not: what follows is with it among these"


def _bars() -> Bars:
    """Return what shows on standard error what is being done, and for how long."""
    columns = (SpinnerColumn(), description_column(), TimeElapsedColumn())
    return Bars(*columns, transient=True)


def _shown_in(bars: Bars) -> Callable[[str], None]:
    """Return what shows in a bar what is being tested."""
    task = bars.add_task("Reading", total=None)  # how much there is to test shows only on the way
    return lambda what: bars.update(task, description=f"Testing {what}")


def _print_data(data_set: DataSet, notices: Sequence[str]) -> None:
    fit, held_out = data_set.fit_records, data_set.heldout_records
    entry("Runs", f"fitted: {', '.join(fit)}; held out: {', '.join(held_out) or 'none'}")
    for notice in notices:
        warn("note", notice)


def _print_gap(diagnosis: Diagnosis, places: Sequence[ResidualSegment]) -> None:
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


def _print_untestable(diagnosis: Diagnosis) -> None:
    if by_need := lacking(diagnosis):
        say()
        entries("Untestable", [f"needs {needs}: {', '.join(effects)}" for needs, effects in by_need.items()])


def _print_step(diagnosis: Diagnosis, step: Step) -> None:
    say()
    show(candidates_table(step.screening, untested=diagnosis.untested(step.screening)))
    say()
    _print_addition(addition_of(diagnosis, step))
    number = diagnosis.steps.index(step)
    last = diagnosis.steps[number - 1].after if number else diagnosis.gap_before
    if in_other_noise(step.before, last):
        entry("Noise", "re-estimated before that: so the misfit and the gap without the effect differ from those above")
    entry("Misfit", misfit_change_words(step.before, step.after))
    if gimbals := gimbals_words(step.before, step.after):
        entry("", gimbals)
    entry("Gap", f"{gap_words(step.before)} -> {gap_words(step.after)}")


def _print_addition(addition: Addition) -> None:
    entries("Added", [effect_name(addition.effect, addition.component), *addition_words(addition)])


def _print_rest(diagnosis: Diagnosis) -> None:
    if diagnosis.remaining is not None and not diagnosis.steps:
        say()
        show(candidates_table(diagnosis.remaining, on_the_noise(diagnosis), diagnosis.untested(diagnosis.remaining)))
    for scatter in filterfalse(diagnosis.as_in_reference, diagnosis.scatter):
        say()
        _print_addition(addition_of(diagnosis, scatter))
    hidden = confounded(diagnosis)
    if hidden:
        say()
    for placed, by in hidden:
        entry("Untestable", f"{effect_name(placed.effect, placed.component)}: needs {unconfounded_needs(by)}")
    if diagnosis.latent is not None:
        say()
        entry("Residual", f"an unmodelled torque: {chance_words(diagnosis.latent.p_value)}")
        entry("", shape_words(diagnosis).strip() or "no torque of a known shape either")
        if share := share_words(diagnosis):
            entry("", share)


def _print_end(result: DiagnosisResult) -> None:
    diagnosis, agreed = result.state, result.agreements
    say()
    for each in agreed:
        entry("Run by run", f"{effect_name(each.placed.effect, each.placed.component)}: {agreement_words(each)}")
        if each.disagrees:
            show(sizes_table(each))
    if agreed:
        say()
    _print_together(diagnosis)
    show(inertia_table(diagnosis))
    say()
    verdict = diagnosis_verdict(diagnosis)
    colour = {"good": "green", "warn": "yellow", "bad": "red"}.get(verdict.tone, "default")
    console.print(Text.assemble(("Verdict", colour), f"    {diagnosis.verdict or 'not reached'}"))
    entry("", verdict.text)


def _print_together(diagnosis: Diagnosis) -> None:
    """Print the sizes of effects in the model that has all of them; each was printed as it was when it was added."""
    if len(diagnosis.steps) < 2:
        return
    added = [addition_of(diagnosis, step) for step in diagnosis.steps]
    lines = [
        f"{effect_name(each.effect, each.component)}: {quantity_words(quantity)}"
        for each in added
        for quantity in each.quantities
    ]
    entries("With all", lines)
    say()


def _print_next(folder: Path, proposal: Proposal | None) -> None:
    if proposal is None:
        return
    say()
    entry("Next", flight_words(proposal))
    for separation in proposal.separations[:_PAIRS_SHOWN]:
        entry("", f"{pair_words(separation)}: {distance_words(separation)}")
    if wanted := [each.wanted for each in proposal.separations if each.separable]:
        entry("", f"{figures(max(wanted), 2)} sigma distinguish any two in 95 of 100 cases")
    if proposal.flight is not None:
        say("           Fly it on the platform itself; what the nominal model makes of it:")
        say(f"           {further_command('run', folder / NEXT / SCENARIO)}")


def _print_folder(folder: Path) -> None:
    say()
    print_folder(folder)
    say(f"Recording  {further_command('view', folder)}")
