"""The tables ``[people.NAME]``."""

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from homebot.gateways.base import GatewaySettings
from homebot.units import Seconds

_Name = Annotated[str, Field(min_length=1, max_length=100)]


class PersonSettings(BaseModel):
    """One person.

    Attributes:
        trackers: The names or ids of devices with a place, such as those of a phone in another system.
        ping: The address of the person's phone, which is asked every half minute; empty for none.
        away_after: Seconds of silence after which a phone that is only heard at home counts as away; until then it is
            unknown where the person is.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    trackers: Annotated[tuple[_Name, ...], Field(max_length=20)] = ()
    ping: Annotated[str, Field(max_length=253, pattern=r"^[A-Za-z0-9:._%-]*$")] = ""
    away_after: Annotated[Seconds, Field(ge=60)] = 1200.0

    @model_validator(mode="after")
    def _check_sources(self) -> Self:
        if not self.trackers and not self.ping:
            raise ValueError('give `trackers`, such as ["Anna\'s phone"], or `ping`, the address of a phone')
        return self


class PeopleSettings(GatewaySettings):
    """The people by name, beside those of other systems."""

    people: Annotated[dict[_Name, PersonSettings], Field(default_factory=dict, max_length=50)]


def gateway_of_people(people: object, _: Mapping[str, object]) -> dict[str, dict[str, object]]:
    """Return the table of the gateway, whose devices are *people*."""
    return {"people": {"people": people}}
