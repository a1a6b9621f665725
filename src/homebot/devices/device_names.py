"""Devices and persons by the names that people write, see :mod:`homebot.support.names`. Pure.

All that takes the name of a device asks here: commands, the command line, HTTP and agents, services, configurations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from homebot.support.folding import fold
from homebot.support.names import spellings

if TYPE_CHECKING:
    from homebot.devices.device import Device
    from homebot.devices.query.terms import Query

_MAX_NAMED = 10


def names_of(device: Device) -> tuple[str, ...]:
    """Return the id and all names of *device*."""
    return device.id, device.name, *device.names


def is_called(device: Device, name: str) -> bool:
    """Return whether *name* is the id or a name of *device*, also one in dispute, whatever its case and accents."""
    stated = (fact.value for fact in device.facts if fact.name == "name")
    return fold(name) in map(fold, (*names_of(device), *stated))


def name_query(text: str, device_id: str = "") -> Query:
    """Return the query for the devices of which :func:`devices_called` chooses."""
    from homebot.devices.query.terms import FactIs, NameIs, Or  # noqa: PLC0415 - the command line sends words

    return Or((FactIs("id", (device_id or text).casefold()), *map(NameIs, dict.fromkeys(map(fold, spellings(text))))))


def devices_called(text: str, devices: Iterable[Device], device_id: str = "") -> tuple[Device, ...]:
    """Return the one of *devices* with the id *text*; else all that *text* calls by id or name.

    A name as it is written outranks one without quotes, and this one without an article.

    Args:
        device_id: The id in *text*, if that is ``ID#PART``; its case does not count.
    """
    devices = tuple(devices)
    if exact := tuple(device for device in devices if device.id == (device_id or text)):
        return exact
    is_part = device_id not in {"", text}
    by_id = tuple(device for device in devices if is_part and device.id.casefold() == device_id.casefold())
    for name in () if by_id else spellings(text):
        if called := tuple(device for device in devices if is_called(device, name)):
            return called
    return by_id


def ask_which(name: str, called: Sequence[Device]) -> str:
    """Return the request for the id of one of the devices *called* so."""
    ids = ", ".join(sorted(device.id for device in called)[:_MAX_NAMED])
    return f"{len(called)} devices are called {name}; give the id of one: {ids}"
