"""A record cut where it shows its first contact."""

from __future__ import annotations

from dataclasses import replace

from testbed.assembly.platform import Body
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.estimation.contact import Contact, first_contact
from testbed.records.record import Record
from testbed.scenario.body import BodyScenario


def cut_at_contact(record: Record, scenario: BodyScenario, nominal: Body) -> tuple[Record, Contact | None]:
    """Return the record, usable up to the first contact that it shows, and that contact.

    A record that states its usable_to, or shows no contact, is returned as it is.

    Args:
        record: telemetry, flown or measured.
        scenario: the gyro's noise where the record does not show it.
        nominal: the nominal platform.

    Raises:
        InputError: the record lacks what the search needs.
    """
    if record.details.usable_to is not None:
        return record, None
    contact = first_contact(telemetry_of(record, scenario, nominal), theta_of(nominal.turned_inertia))
    if contact is None:
        return record, None
    return replace(record, details=replace(record.details, usable_to=contact.last_free)), contact
