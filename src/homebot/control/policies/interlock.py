"""Interlocks: what is not done while something else is so, such as heating with an open window. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts
from homebot.control.policies.settings import Interlock
from homebot.control.policies.verdict import FactUsed, Verdict
from homebot.devices import Device
from homebot.devices.query import And, Not, Or, PartFacets, Query, StateIs, fits

__all__ = ["judge_interlocks", "without_states"]

NAME: Final = "interlock"

_NOT_CONCERNED: Final = Verdict(NAME, allowed=True)


def judge_interlocks(tables: Iterable[Interlock], command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command while the condition of one of *tables* holds, or while that is unknown."""
    for interlock in tables:
        if not any(pattern.fits(command) for pattern in interlock.commands):
            continue
        room = command.device.area if interlock.where == "room" else None
        if not facts.house.is_known or room == "":
            what = "the state of the house" if room != "" else "the room of the device"
            return Verdict(NAME, allowed=False, reason=f"not while {interlock.condition}: {what} is unknown")
        if (verdict := _judge(interlock, room, facts)) is not None:
            return verdict
    return _NOT_CONCERNED


def without_states(query: Query, *, is_possible: bool = True) -> Query:
    """Return the query for what may match *query*, whatever values are reported; else for what must match it."""
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


def _judge(interlock: Interlock, room: str | None, facts: Facts) -> Verdict | None:
    query, condition = interlock.query, interlock.condition
    possible = without_states(query)
    capabilities = frozenset(_capabilities(query))
    for device in facts.house.devices(room):
        if not device.parts:
            continue
        facets = PartFacets(device)
        for part in device.parts:
            facets.part = part
            if not fits(possible, facets):
                continue
            used = tuple(_facts(device, part.id, capabilities))
            is_known = device.freshness == "fresh" and facets.reachable != "no"
            if not is_known or (capabilities and not used):
                reason = f"not while {condition}: whether {device.name} is so is unknown"
            elif fits(query, facets):
                reason = f"not while {condition}: {device.name} is so"
            else:
                continue
            return Verdict(NAME, allowed=False, reason=reason, facts=used)
    return None


def _capabilities(query: Query) -> Iterator[str]:
    match query:
        case StateIs():
            yield query.capability
        case And(terms) | Or(terms):
            for term in terms:
                yield from _capabilities(term)
        case Not(term):
            yield from _capabilities(term)


def _facts(device: Device, part: str, capabilities: frozenset[str]) -> Iterator[FactUsed]:
    for state in device.states:
        value = state.value.plain()
        if state.part == part and state.capability in capabilities and state.live and value is not None:
            yield FactUsed(f"{state.capability} of {device.id}", value, state.since.to_seconds())
