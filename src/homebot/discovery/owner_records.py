"""The owner's statements as text for the index file, and back. Pure."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from homebot.config import value_errors
from homebot.discovery.approvals import ApprovalRecord, ApprovalRegistry
from homebot.discovery.source_record import SourceKey
from homebot.errors import WireError
from homebot.places import HouseDoor, HouseRoom, OwnerFact, read_position

__all__ = ["PlacesRecord", "places_record", "read_places_record"]


class _StatementRecord(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    facts: tuple[OwnerFact, ...]
    announcements: tuple[tuple[str, str], ...] = ()
    names: tuple[str, ...] = ()

    @field_validator("facts")
    @classmethod
    def _with_positions_that_can_be_read(cls, facts: tuple[OwnerFact, ...]) -> tuple[OwnerFact, ...]:
        with value_errors():
            for fact in facts:
                if fact.name.endswith("position"):
                    read_position(fact.value)
        return facts


class PlacesRecord(BaseModel):
    """The statements, imported rooms and approvals in the index file."""

    model_config = ConfigDict(extra="ignore", defer_build=True)

    statements: tuple[_StatementRecord, ...] = ()
    rooms: tuple[HouseRoom, ...] = ()
    doors: tuple[HouseDoor, ...] = ()
    known_as: tuple[tuple[str, str, str], ...] = ()
    approvals: tuple[ApprovalRecord, ...] = ()


def places_record(
    statements: Iterable[tuple[tuple[OwnerFact, ...], Iterable[SourceKey], Iterable[str]]],
    rooms: Iterable[HouseRoom],
    doors: Iterable[HouseDoor],
    known_as: Mapping[SourceKey, str],
    approvals: ApprovalRegistry,
) -> str:
    """Return a :class:`PlacesRecord` as text.

    Args:
        statements: Facts, with the announcements and the names that they are stated of.
        known_as: The name of each announcement in the configuration.
    """
    record = {
        "statements": [
            {"facts": [fact._asdict() for fact in facts], "announcements": list(keys), "names": list(names)}
            for facts, keys, names in statements
        ],
        "rooms": [one._asdict() for one in rooms],
        "doors": [one._asdict() for one in doors],
        "known_as": [[*key, name] for key, name in known_as.items()],
        "approvals": approvals.records(),
    }
    return json.dumps(record)


def read_places_record(text: str) -> PlacesRecord:
    """Return the record of a text.

    Raises:
        WireError: It is no such text.
    """
    try:
        return PlacesRecord.model_validate_json(text)
    except ValidationError as exc:
        raise WireError(f"no places: {exc.errors()[0]['msg']}", text[:100].encode(errors="replace")) from exc
