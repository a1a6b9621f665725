"""Conditions of routines, as text. Pure."""

import re
from dataclasses import dataclass
from typing import Final, TypeAlias

from homebot.devices.query.terms import Not
from homebot.errors import UsageError
from homebot.routines.people import check_known, read_person
from homebot.routines.times import TimeSpan, read_days_of_week
from homebot.routines.triggers import Becomes, Press, read_press, read_state

__all__ = ["Condition", "Matches", "OnDays", "SunIs", "read_condition"]

_SUN: Final = {"sun is up": True, "sun is down": False, "it is dark": False, "it is light": True}
_NOBODY: Final = re.compile(
    r"(?P<word>nobody|somebody)\s+(?:is\s+)?(?P<sleeps>sleeps\s+)?in\s+(?P<room>.+)", re.IGNORECASE
)
_PRESENCE: Final = "motion occupied in"
_IN_BED: Final = "tag=bed occupied in"
"""Sensors that the owner tagged as those of a bed, such as a Withings Sleep mat or a zone of an Aqara FP2."""
_NONE: Final = re.compile(r"(?:no|not|none of)\s+(?P<state>.+)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class SunIs:
    """The sun is above the horizon, or below it."""

    is_up: bool


@dataclass(frozen=True, slots=True)
class OnDays:
    """It is one of these days of the week; Monday is 0."""

    days: frozenset[int]


@dataclass(frozen=True, slots=True)
class Matches:
    """At least one device matches, or none does."""

    state: Becomes
    is_none: bool = False


Condition: TypeAlias = SunIs | OnDays | TimeSpan | Matches | Press
"""A press holds in the run that it started."""


def read_condition(text: str) -> Condition:
    """Return the condition *text*.

    Raises:
        UsageError: It is none; the message shows how it could be written.
    """
    plain = " ".join(text.split())
    if (is_up := _SUN.get(plain.casefold())) is not None:
        return SunIs(is_up)
    if (days := read_days_of_week(plain)) is not None:
        return OnDays(days)
    if (span := TimeSpan.read(plain)) is not None:
        return span
    if (found := _NOBODY.fullmatch(plain)) is not None:
        seen = _IN_BED if found["sleeps"] else _PRESENCE
        return Matches(read_state(f"{seen} {found['room']}"), found["word"].casefold() == "nobody")
    if (press := read_press(plain)) is not None:
        return press
    none = None if read_person(plain) else _NONE.fullmatch(plain)
    state = read_state(none["state"] if none else plain)
    if none is not None:
        check_known(text, Not(state.query))
    if state.lasting:
        raise UsageError(f"{text!r}: a condition holds now; only `when` and `wait until` can ask for how long")
    return Matches(state, none is not None)
