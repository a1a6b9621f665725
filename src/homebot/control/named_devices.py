"""The rooms and devices that the table ``[control]`` names."""

from __future__ import annotations

from homebot.control.settings import ControlSettings
from homebot.devices.misspelt_names import ConfiguredNames
from homebot.devices.query.parse import parse_query
from homebot.graph import Node

__all__ = ["named_devices"]

_WITNESSES = "control.witnesses"
_DOORS = "control.presence_guard.doors"


def named_devices(node: Node, settings: ControlSettings) -> ConfiguredNames:
    """Return what looks for the sensors, contacts and rooms that *settings* name, and for what their queries fit."""
    doors = settings.presence_guard.doors if settings.presence_guard is not None else {}
    contacts = [(f"{_DOORS}.{room}", contact) for room, named in doors.items() for contact in named]
    sensors = [(f"{_WITNESSES}.{query!r}", sensor) for query, sensor in settings.witnesses.items() if sensor.strip()]
    return ConfiguredNames(
        node,
        rooms=[(_DOORS, room) for room in doors],
        devices=[*contacts, *sensors],
        queries=[(_WITNESSES, query, parse_query(query)) for query in settings.witnesses],
    )
