"""Explanation of a query that no device fits."""

from __future__ import annotations

from collections.abc import Iterator

from homebot.cli.device_queries import all_devices, find_devices
from homebot.cli.door_client import DoorClient
from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, InArea, Or, Query
from homebot.devices.query.tokens import quoted
from homebot.support.similar import did_you_mean

__all__ = ["why_none"]

_SOME = 12


def why_none(door: DoorClient, query: str) -> str:
    """Return why *query* finds nothing: the area that no device is in, if there is one."""
    for area in _areas(parse_query(query)):
        if not find_devices(door, f"in {quoted(area)}", 1).total:
            areas = all_devices(door, lambda device: (device.area, *device.outer_areas))
            known = {one for some in areas for one in some if one}
            some = (
                f"areas are {', '.join(sorted(known)[:_SOME])}"
                if known
                else "`homebot place DEVICE ROOM` says which room a device is in"
            )
            return f"no device is in {area!r}; {did_you_mean(area, known, some)}"
    return f"no device matches {query!r}; `homebot devices` lists all"


def _areas(query: Query) -> Iterator[str]:
    match query:
        case InArea(area):
            yield area
        case And(terms) | Or(terms):
            for term in terms:
                yield from _areas(term)
