"""The owner's statements as text for the index file, and back. Pure."""

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from homebot.config import value_errors
from homebot.devices.part import CommandDescription
from homebot.errors import WireError
from homebot.places import HouseDoor, HouseRoom, OwnerFact, read_position


class StatementRecord(BaseModel):
    """Facts, with the announcements and names to which they apply."""

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
    """The statements, imported rooms and approvals in the index file.

    Attributes:
        known_as: Gateway and key of announcements, each with its name in the configuration.
        approvals: Gateway, key, part, description and time of each.
    """

    model_config = ConfigDict(extra="ignore", defer_build=True)

    statements: tuple[StatementRecord, ...] = ()
    rooms: tuple[HouseRoom, ...] = ()
    doors: tuple[HouseDoor, ...] = ()
    known_as: tuple[tuple[str, str, str], ...] = ()
    approvals: tuple[tuple[str, str, str, CommandDescription, float], ...] = ()


def read_places_record(text: str) -> PlacesRecord:
    """Parse a record.

    Raises:
        WireError: It is invalid.
    """
    try:
        return PlacesRecord.model_validate_json(text)
    except ValidationError as exc:
        raise WireError(f"no places: {exc.errors()[0]['msg']}", text[:100].encode(errors="replace")) from exc
