"""The folder of flights until a verdict is sure: records and plan.json as they come, the page at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from testbed.assembly.extension import SCENARIO
from testbed.errors import InputError
from testbed.files import read_text, whole_file, write_json
from testbed.formats.plan import PlanResult
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.scenario import write_next
from testbed.outputs.provenance import Provenance
from testbed.records.reading import read_record
from testbed.records.record import Record
from testbed.records.writing import table_path, write_record
from testbed.report.plan import write_plan_page
from testbed.scenario.scenario import Scenario

PLAN = "plan.json"
RECORDS = "records"
FLIGHTS = "flights"
_LARGEST = 10_000_000
"""Bytes of plan.json; each flight takes one kilobyte."""


@dataclass(frozen=True, kw_only=True)
class PlanFolder:
    """Where a campaign is kept. Every file is written whole, plan.json last: what it lists is there.

    Attributes:
        path: of the folder.
    """

    path: Path

    def kept(self) -> tuple[PlanResult, list[Record]]:
        """Return the campaign that the folder holds, and its records, in order.

        Raises:
            InputError: it holds none, or what it holds was changed.
        """
        path = self.path / PLAN
        if not path.is_file():
            raise InputError(
                f"{self.path}: holds no {PLAN}, so that there is nothing to go on with; begin without resume"
            )
        try:
            state = PlanResult.model_validate_json(read_text(path, "the state of a campaign", _LARGEST).text)
        except ValidationError as error:
            first = error.errors()[0]
            raise InputError(
                f"{path}: is not as testbed wrote it ({first['msg']}); begin again in a new folder"
            ) from error
        return state, [read_record(self.path / RECORDS / f"{flight.record}.parquet") for flight in state.flights]

    def keep(self, state: PlanResult, scenario: Scenario, records: Sequence[Record]) -> None:
        """Write what is known so far: the scenario as it was read, records that are not there yet, then plan.json.

        Raises:
            InputError: a record's name can be no file's.
        """
        if not (self.path / SCENARIO).exists():
            with whole_file(self.path / SCENARIO) as part:
                part.write_bytes(scenario.file.content)
        for record in records:
            if not table_path(record, self.path / RECORDS).exists():
                write_record(record, self.path / RECORDS)
        with whole_file(self.path / PLAN) as part:
            write_json(part, state.model_dump(mode="json", by_alias=True))

    def propose(self, scenario: Scenario, flight: NextFlight, number: int, purpose: str) -> str:
        """Write the scenario of a flight; return its path, relative to the folder."""
        folder = Path(FLIGHTS) / f"{number:02d}"
        write_next(scenario, flight, purpose, self.path / folder)
        return (folder / SCENARIO).as_posix()

    def finish(self, state: PlanResult, origin: Provenance) -> None:
        """Write the page and the provenance."""
        with whole_file(self.path / "provenance.json") as part:
            write_json(part, origin.content)
        write_plan_page(self.path / "report.html", state, origin.listed)


def new_records(state: PlanResult, records: Sequence[Record]) -> list[Record]:
    """Return those records that a campaign does not have yet, in their order.

    Raises:
        InputError: one has the name of a flight that it has, and other content.
    """
    known = {flight.record: flight.source_sha256 for flight in state.flights}
    new = []
    for record in records:
        name = record.details.name
        if name not in known:
            new.append(record)
        elif known[name] != source_of(record):
            raise InputError(
                f"{name}: the campaign has another flight of this name; give each record a name of its own"
            )
    return new


def source_of(record: Record) -> str | None:
    """Return the hash of the file that a record was read from; None of one that a program made."""
    return record.files[0].sha256 if record.files else None
