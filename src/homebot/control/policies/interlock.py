"""Interlocks: commands that are refused while a condition holds, such as heating with an open window. Pure."""

from collections.abc import Iterator
from functools import cached_property
from typing import Final, Literal

from pydantic import Field

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.devices import Device, DevicePart
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import And, Not, Or, Query, StateIs, leaves
from homebot.words.exact_queries import parse_cautious_query
from homebot.words.patterns import Patterns, QueryText

NAME: Final = "interlock"


class Interlock(PolicyTable):
    """A table ``[[control.interlocks]]``.

    Attributes:
        condition: The query, written as ``while``: commands are refused while a device matches it.
        where: Whether that device must be in the same room as the commanded one, or may be anywhere in the home.
    """

    commands: Patterns
    condition: QueryText = Field(alias="while")
    where: Literal["room", "home"] = "room"

    @cached_property
    def _query(self) -> Query:
        return parse_cautious_query(self.condition)

    @cached_property
    def _capabilities(self) -> frozenset[str]:
        return frozenset([leaf.capability for leaf in leaves(self._query) if isinstance(leaf, StateIs)])

    @cached_property
    def needs(self) -> Query:
        """The devices that may ever match the condition."""
        return without_states(self._query)

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse a command while the condition holds, or may hold."""
        if any(pattern.fits(command, facts) for pattern in self.commands):
            room = command.device.area if self.where == "room" else None
            if not facts.house.is_known or room == "":
                unknown = "the state of the house" if room != "" else "the room of the device"
                return Verdict(NAME, allowed=False, reason=f"not while {self.condition}: {unknown} is unknown")
            for device, part in self._concerned_parts(room, facts):
                if (verdict := self._check_part(device, part, is_by_person=command.is_by_person)) is not None:
                    return verdict
        return Verdict(NAME, allowed=True)

    def _concerned_parts(self, room: str | None, facts: Facts) -> Iterator[tuple[Device, DevicePart]]:
        for tracked in facts.house.devices(room):
            for part in tracked.device.parts:
                if self._capabilities and not any(
                    capability.name in self._capabilities for capability in part.part.capabilities
                ):
                    continue
                if fits(self.needs, PartFacets(tracked.device, part)):
                    yield tracked.current(), part

    def _check_part(self, device: Device, part: DevicePart, *, is_by_person: bool) -> Verdict | None:
        facets = PartFacets(device, part)
        is_there = facets.reachable == "yes"
        used = tuple(_facts(device, part.id, self._capabilities, is_there=is_there))
        is_known = bool(used) if self._capabilities else is_there or device.freshness == "fresh"
        doubt = "" if is_known else "it has reported nothing yet since homebot started"
        if facets.reachable == "no":
            doubt = "it is unreachable"
        elif device.freshness == "stale":
            doubt = "it has been silent for too long"
        if doubt:
            reason = f"not while {self.condition}, and the state of {device.name} is unknown: {doubt}"
            return Verdict(NAME, is_by_person, reason, used, warns=is_by_person)
        if not fits(self._query, facets):
            return None
        return Verdict(NAME, allowed=False, reason=f"not while {self.condition}: {device.name}", facts=used)


def without_states(query: Query, *, is_possible: bool = True) -> Query:
    """Return the query for the parts that may ever match *query*; if not *is_possible*, for those that always do."""
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


def _facts(device: Device, part: str, capabilities: frozenset[str], *, is_there: bool) -> Iterator[FactUsed]:
    """Yield the known states; a retained one counts if its bridge or its availability says that the device is there."""
    is_fresh = device.freshness == "fresh"
    for state in device.states:
        value = state.value.plain()
        is_current = is_there or (state.live and is_fresh)
        if state.part == part and state.capability in capabilities and is_current and value is not None:
            yield FactUsed(f"{state.capability} of {device.id}", value, state.since.to_seconds())
