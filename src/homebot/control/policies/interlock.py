"""Interlocks: commands that are refused while a condition holds, such as heating with an open window. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Final, Literal, NamedTuple

from pydantic import Field

from homebot.control.command import IssuedCommand
from homebot.control.policies.command_pattern import Patterns, QueryText
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.devices import Device, DevicePart
from homebot.devices.query import And, Not, Or, PartFacets, Query, StateIs, fits
from homebot.devices.query.exact import parse_lasting_query
from homebot.devices.query.terms import leaves

__all__ = ["Interlock"]

NAME: Final = "interlock"


class _Rule(NamedTuple):
    """The parsed condition of an interlock.

    Attributes:
        possible: The query for the parts that may match it at some time.
    """

    condition: str
    query: Query
    possible: Query
    capabilities: frozenset[str]


class Interlock(PolicyTable):
    """A table ``[[control.interlocks]]``.

    Attributes:
        condition: The query, written as ``while``: the commands are refused while a device matches.
        where: Whether that device must be in the room of the commanded one, or may be anywhere in the home.
    """

    commands: Patterns
    condition: QueryText = Field(alias="while")
    where: Literal["room", "home"] = "room"

    @cached_property
    def _rule(self) -> _Rule:
        query = parse_lasting_query(self.condition)
        capabilities = frozenset([one.capability for one in leaves(query) if isinstance(one, StateIs)])
        return _Rule(self.condition, query, without_states(query), capabilities)

    @property
    def needs(self) -> Query:
        """The devices that may match the condition at some time."""
        return self._rule.possible

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse a command while the condition holds, or while that is unknown."""
        if any(pattern.fits(command, facts) for pattern in self.commands):
            room = command.device.area if self.where == "room" else None
            if not facts.house.is_known or room == "":
                unknown = "the state of the house" if room != "" else "the room of the device"
                return Verdict(NAME, allowed=False, reason=f"not while {self.condition}: {unknown} is unknown")
            for device, part in _concerned_parts(self._rule, room, facts):
                if (verdict := _check_part(self._rule, device, part)) is not None:
                    return verdict
        return Verdict(NAME, allowed=True)


def without_states(query: Query, *, is_possible: bool = True) -> Query:
    """Return the query for the parts that may match *query* at some time; else for those that match it at any time."""
    match query:
        case StateIs():
            return And(()) if is_possible else Or(())
        case And(terms):
            return And(tuple(without_states(term, is_possible=is_possible) for term in terms))
        case Or(terms):
            return Or(tuple(without_states(term, is_possible=is_possible) for term in terms))
        case Not(term):
            return Not(without_states(term, is_possible=not is_possible))
    return query


def _concerned_parts(rule: _Rule, room: str | None, facts: Facts) -> Iterator[tuple[Device, DevicePart]]:
    for tracked in facts.house.devices(room):
        for part in tracked.device.parts:
            if rule.capabilities and not any(one.name in rule.capabilities for one in part.part.capabilities):
                continue
            if fits(rule.possible, PartFacets(tracked.device, part)):
                yield tracked.current(), part


def _check_part(rule: _Rule, device: Device, part: DevicePart) -> Verdict | None:
    condition = rule.condition
    facets = PartFacets(device, part)
    used = tuple(_facts(device, part.id, rule.capabilities))
    if doubt := _doubt(device, is_away=facets.reachable == "no", is_silent=bool(rule.capabilities) and not used):
        reason = f"not while {condition}, and the state of {device.name} is unknown: {doubt}"
    elif fits(rule.query, facets):
        reason = f"not while {condition}: {device.name}"
    else:
        return None
    return Verdict(NAME, allowed=False, reason=reason, facts=used)


def _doubt(device: Device, *, is_away: bool, is_silent: bool) -> str:
    """Return why the present state of a part is unknown; empty if it is known."""
    if is_away:
        return "it is unreachable"
    if device.freshness == "stale":
        return "it has been silent for too long"
    return "it has reported nothing yet since homebot started" if device.freshness != "fresh" or is_silent else ""


def _facts(device: Device, part: str, capabilities: frozenset[str]) -> Iterator[FactUsed]:
    for state in device.states:
        value = state.value.plain()
        if state.part == part and state.capability in capabilities and state.live and value is not None:
            yield FactUsed(f"{state.capability} of {device.id}", value, state.since.to_seconds())
