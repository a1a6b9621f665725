"""Explanation of a query that no device fits."""

from __future__ import annotations

from collections.abc import Iterator

from homebot.cli.device_queries import all_devices, find_devices
from homebot.cli.door_client import DoorClient
from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, InArea, Or, Query
from homebot.devices.query.tokens import quoted
from homebot.support.similar import did_you_mean

__all__ = ["unknown_area"]

_SOME = 12


def unknown_area(door: DoorClient, query: str) -> str:
    """Return which area of *query*, which found nothing, no device is in; empty if there is none."""
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
    return ""


def _areas(query: Query) -> Iterator[str]:
    match query:
        case InArea(area):
            yield area
        case And(terms) | Or(terms):
            for term in terms:
                yield from _areas(term)
