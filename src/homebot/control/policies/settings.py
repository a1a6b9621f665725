"""Settings of the policies: the tables and keys of ``[control]`` that say what is never done. Pure."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from homebot.control.policies.command_pattern import CommandPattern, Patterns, pattern_of_type
from homebot.units import Seconds

__all__ = ["PolicySettings", "PresenceGuardSettings"]


def _annoying() -> tuple[CommandPattern, ...]:
    return (
        *(pattern_of_type("turn off", word) for word in ("light", "plug", "switch")),
        *(pattern_of_type("close", word) for word in ("window_covering", "closure", "water_valve")),
    )


class PresenceGuardSettings(BaseModel):
    """The table ``[control.presence_guard]``.

    Attributes:
        commands: The commands that are not given by an app where somebody is, or where that is unknown.
        absent_after: Seconds without motion after which nobody is there: somebody who reads does not move.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    commands: Patterns = Field(default_factory=_annoying)
    absent_after: Seconds = 300.0


def _table(value: object) -> object:
    """Return the table that ``true`` means, or that there is none for ``false``."""
    return ({} if value else None) if isinstance(value, bool) else value


class PolicySettings(BaseModel):
    """The part of the table ``[control]`` that is about policies.

    Attributes:
        presence_guard: Whether apps may not turn things off or close them where somebody is: ``true``, or a table for
            how.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    presence_guard: Annotated[PresenceGuardSettings | None, BeforeValidator(_table)] = None

    @property
    def needs_house(self) -> bool:
        """True if some policy needs the values of sensors."""
        return self.presence_guard is not None
