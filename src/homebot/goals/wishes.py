"""The wishes of a goal in words. Pure."""

import re
from collections.abc import Collection
from dataclasses import dataclass
from typing import Final, TypeAlias

from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, AreaIs, Not, Or, Query, StateIs, leaves, split_near, type_is
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["RobotWish", "StateWish", "Wish", "read_wishes"]

_JOINED: Final = re.compile(r"""((?:"[^"]*"|\([^)]*\)|(?!\s+and\s|,).)+)(?:\s+and\s+|\s*,\s*|$)""", re.IGNORECASE)
_LIT: Final = re.compile(r"(?:the\s+)?(?P<room>.+?)\s+(?:is\s+)?(?P<word>lit|dark)", re.IGNORECASE)
_IN: Final = re.compile(r"(?P<robot>[\w-]+)\s+(?:is\s+)?in\s+(?:the\s+)?(?P<room>.+)", re.IGNORECASE)
_HOW: Final = "write it like 'kitchen lit', 'hall dark', 'rosie in kitchen', 'hall lamp on' or 'front door closed'"
_EVERYTHING: Final = And(())


@dataclass(frozen=True, slots=True)
class RobotWish:
    """A robot is in a room."""

    text: str
    robot: str
    room: str


@dataclass(frozen=True, slots=True)
class StateWish:
    """Parts are in a state.

    Attributes:
        target: The parts in any state.
        query: The parts in that state.
        name: The words without the last one, which may be the name of a device.
        any_of: Whether one of them is enough.
    """

    text: str
    target: Query
    query: Query
    name: str
    any_of: bool = False


Wish: TypeAlias = RobotWish | StateWish


def read_wishes(text: str, rooms: Collection[str]) -> tuple[Wish, ...]:
    """Return the wishes of the goal *text* for a house with *rooms*.

    Raises:
        UsageError: A wish is not understood, or names no room; the message suggests one.
    """
    found = [_wish(one.strip(), rooms) for one in _JOINED.findall(text) if one.strip()]
    if not found:
        raise UsageError(f"the goal is empty; {_HOW}")
    places: dict[str, RobotWish] = {}
    for one in found:
        if isinstance(one, RobotWish) and places.setdefault(fold(one.robot), one).room != one.room:
            raise UsageError(f"{one.robot} cannot be in {places[fold(one.robot)].room} and in {one.room} at once")
    return tuple(dict.fromkeys(found))


def _wish(text: str, rooms: Collection[str]) -> Wish:
    if (lit := _LIT.fullmatch(text)) is not None:
        room, is_lit = _room(lit["room"], rooms), fold(lit["word"]) == "lit"
        lights = And((type_is("light"), AreaIs(fold(room))))
        wanted = And((lights, StateIs("on_off", "=", is_lit)))
        return StateWish(f"{room} {'lit' if is_lit else 'dark'}", lights, wanted, "", any_of=is_lit)
    query = parse_query(text)
    if any(isinstance(one, StateIs) for one in leaves(query)):
        split_near(query)
        target = _stateless(query)
        if not any(one != _EVERYTHING for one in leaves(target)):
            raise UsageError(f"{text!r} names no device; {_HOW}")
        return StateWish(text, target, query, fold(text.rpartition(" ")[0]).removesuffix(" is"))
    if (placed := _IN.fullmatch(text)) is None:
        raise UsageError(f"{text!r} names no state; {_HOW}")
    return RobotWish(text, placed["robot"], _room(placed["room"], rooms))


def _room(name: str, rooms: Collection[str]) -> str:
    for one in rooms:
        if fold(one) == fold(name):
            return one
    hint = did_you_mean(name, rooms, f"rooms are {', '.join(rooms) or 'none'}")
    raise UsageError(f"there is no room {name!r}; {hint}")


def _stateless(query: Query) -> Query:
    """Return *query* with everything true in place of states."""
    match query:
        case And(terms):
            return And(tuple(one for one in map(_stateless, terms) if one != _EVERYTHING))
        case Or(terms):
            known = tuple(map(_stateless, terms))
            return _EVERYTHING if _EVERYTHING in known else Or(known)
        case Not(term) if any(isinstance(one, StateIs) for one in leaves(term)):
            return _EVERYTHING
        case StateIs():
            return _EVERYTHING
    return query
