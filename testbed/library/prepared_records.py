"""Records as a diagnosis takes them: read for the nominal model, compared with healthy ones where there are any."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from testbed.assembly.platform import Body, nominal_body
from testbed.diagnosis.changed import changed_notices, without_changed
from testbed.diagnosis.gate import Gate, require_explicable
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.missed_records import missed_record
from testbed.diagnosis.reading import DataSet, data_set_of
from testbed.diagnosis.reference import reference_of
from testbed.diagnosis.settings import SETTINGS, PriorOdds
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.library.records import Records, require_runs, stamps_of
from testbed.library.scenarios import naming
from testbed.outputs.provenance import Provenance, provenance
from testbed.scenario.body import BodyScenario

Progress = Callable[[str], None]


def silent(_: str) -> None:
    """Report nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedRecords:
    """Records as the diagnosis takes them.

    Attributes:
        scenario: the nominal model.
        records: that were given.
        nominal: the scenario's platform.
        data: the runs to fit and those to hold out.
        origin: what makes the diagnosis.
        healthy: the diagnosis of healthy records that these are compared with; None without.
    """

    scenario: BodyScenario
    records: Records
    nominal: Body
    data: DataSet
    origin: Provenance
    healthy: Diagnosis | None = None

    @property
    def notices(self) -> tuple[str, ...]:
        """What a reader has to know of the records."""
        notices = (*self.data.notices, *self._reference_words())
        if self.data.heldout is not None:
            return notices
        if self.data.alone:
            return *notices, "a single run gets no name: nothing could verify it; fly another one"
        return *notices, "no run is held out: what is found here is verified on none; fly another run"

    def _reference_words(self) -> Iterator[str]:
        if self.healthy is None:
            return
        own = ", ".join(each.key for each in self.healthy.model.placed) or "nothing beside inertia and noise"
        held_out = () if self.healthy.heldout is None else self.healthy.heldout.record_names
        names = ", ".join((*self.healthy.runs.record_names, *held_out))
        shown = "inertia, trim, noise" if self.healthy.runs.trimmed else "noise"
        yield (
            f"compared with the healthy records {names} (verdict: {self.healthy.verdict}): {shown} and {own} are as "
            "these show them, as uncertain as they differ between these; "
            + (
                "what is named may be in them too, as they show more than effects explain"
                if self.healthy.verdict == "unexplained"
                else "what is named is new"
            )
        )

    def stages(self, progress: Progress = silent, most: int = SETTINGS.most_effects) -> Iterator[Diagnosis]:
        """Yield what is known after every stage of the diagnosis; the last one is complete.

        Where a held-out record shows what the fitted ones do not, all begins again with it among these
        (`Diagnosis.begins_again`).

        Args:
            progress: called with what is being tested.
            most: effects that are added at most.

        Raises:
            InputError: the nominal motion leaves the finite numbers, or no model explains the records.
        """
        for state in self._stages(progress, most):
            missed = missed_record(state) if state.complete else None
            again = None if missed is None else self._fitting(missed)
            if again is None:
                yield state
            else:
                yield from again._stages(progress, most)

    def _fitting(self, name: str) -> PreparedRecords | None:
        """Return the same with a record among those that are fitted; None where roles are stated."""
        data = data_set_of(self.records.runs, self.scenario, self.nominal, [name])
        if name not in data.fit_records:
            return None
        return replace(self, data=data)

    def _stages(self, progress: Progress, most: int) -> Iterator[Diagnosis]:
        data = self.data
        theta = theta_of(self.nominal.inertia)
        stages = diagnosed(
            data.runs,
            data.heldout,
            EFFECTS,
            theta,
            progress,
            NOISE_EFFECTS,
            alone=data.alone,
            given=data.given,
            most=most,
        )
        for state in stages:
            if state.complete and state.differing is None:
                gate = Gate(accepted=self.scenario.diagnosis.accept)
                require_explicable(state.runs, state.gap_before.fit, state.nearest, gate)
                state = replace(state, notices=(*state.notices, *gate.notices))  # noqa: PLW2901
            yield state


def prepared_records(
    scenario: BodyScenario, records: Records, reference: Records | None = None, progress: Progress = silent
) -> PreparedRecords:
    """Return records as a diagnosis takes them.

    Args:
        scenario: the nominal model.
        records: to be diagnosed.
        reference: healthy records, which are diagnosed here; none where None.
        progress: called with what is being tested of these.

    Raises:
        InputError: no record can be used, or they are of another platform or in other units.
    """
    require_runs("records", records)
    if reference is not None:
        require_runs("reference", reference)
    origin = origin_of(scenario, records, "testbed.diagnose", reference)
    with naming(scenario):
        nominal = nominal_body(scenario)
    data = data_set_of(records.runs, scenario, nominal)
    made = PreparedRecords(scenario=scenario, records=records, nominal=nominal, data=data, origin=origin)
    if reference is None:
        return made
    healthy = replace(made, records=reference, data=data_set_of(reference.runs, scenario, nominal))
    *_, last = healthy.stages(lambda what: progress(f"reference: {what}"), SETTINGS.most_effects_of_reference)
    shown = reference_of(last)
    theta = theta_of(nominal.inertia)
    kept, changed = without_changed(shown, data.against(shown).runs, EFFECTS, theta)
    said = (*data.notices, *changed_notices(shown, changed))
    return replace(made, data=replace(data.against(kept), notices=said), healthy=last)


def origin_of(scenario: BodyScenario, records: Records, command: str, reference: Records | None = None) -> Provenance:
    """Return what makes a diagnosis: its files, all settings, versions.

    Args:
        scenario: the nominal model.
        records: measured.
        command: that was given.
        reference: healthy records; none where None.
    """
    stamps = stamps_of(records) + ([] if reference is None else stamps_of(reference))
    stated = scenario.diagnosis
    odds = PriorOdds.stated(stated.null_prior_odds, stated.unmodelled_prior_odds)
    return provenance(scenario, scenario.file, command, data=stamps, deciding=SETTINGS.entries | odds.entries)
