"""Parts of an accessory: one for each service with a known function. Pure.

Source: HomeKit Accessory Protocol Specification R2, chapter 8 (services), 9.62 (Name), 9.91 (Service Label Index).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from homebot.conventions.homekit.accessory import Accessory, HapService
from homebot.conventions.homekit.climate import CLIMATE_ROWS
from homebot.conventions.homekit.lights_and_power import POWER_ROWS
from homebot.conventions.homekit.openings import OPENING_ROWS
from homebot.conventions.homekit.rows import HomekitAbility
from homebot.conventions.homekit.sensors import SENSOR_ROWS
from homebot.devices.part import Part

__all__ = ["HomekitPart", "parts_of"]

_ROWS: Final = (*POWER_ROWS, *OPENING_ROWS, *CLIMATE_ROWS, *SENSOR_ROWS)

_TYPES: Final[Mapping[str, str]] = {
    "light": "43",
    "plug": "47",
    "switch": "49",
    "fan": "40 B7 BB",
    "speaker": "113 228",
    "video_player": "D8",
    "door_lock": "45",
    "closure": "41 81 8B",
    "window_covering": "8C",
    "water_valve": "D0 D7 CF",
    "x_alarm_panel": "7E",
    "thermostat": "4A",
    "room_air_conditioner": "BC",
    "x_humidifier": "BD",
    "air_quality_sensor": "8D 97",
    "occupancy_sensor": "85 86",
    "contact_sensor": "80",
    "water_leak_detector": "83",
    "smoke_co_alarm": "87 7F",
    "temperature_sensor": "8A",
    "humidity_sensor": "82",
    "light_sensor": "84",
    "x_battery": "96",
    "generic_switch": "89 121",
}
"""The types of services of each type of parts."""

_TYPE_OF: Final = {service: kind for kind, services in _TYPES.items() for service in services.split()}
_BATTERY, _HEATER, _COOL_TO = "96", "BC", "D"
_NAME, _CONFIGURED_NAME, _LABEL_INDEX = "23", "E3", "CB"


@dataclass(frozen=True, slots=True)
class HomekitPart:
    """A part of an accessory, with its service and abilities."""

    part: Part
    service: HapService
    abilities: tuple[HomekitAbility, ...]


def parts_of(accessory: Accessory) -> Iterator[HomekitPart]:
    """Yield the parts of an accessory."""
    own_name = accessory.information.text(_NAME)
    for service in accessory.services.values():
        found: dict[str, HomekitAbility] = {}
        for row in _ROWS if service.type in _TYPE_OF else ():
            if row.capability not in found and (ability := row.ability(service)) is not None:
                found[row.capability] = ability
        if found:
            yield HomekitPart(_part(service, own_name, tuple(found.values())), service, tuple(found.values()))


def _part(service: HapService, own_name: str, abilities: tuple[HomekitAbility, ...]) -> Part:
    only_heats = service.type == _HEATER and _COOL_TO not in service.characteristics
    name = service.text(_CONFIGURED_NAME) or service.text(_NAME)
    index = service.number(_LABEL_INDEX)
    if name in {"", own_name}:
        name = "" if index is None else f"{index:g}"
    return Part(
        id=str(service.iid),
        name=name,
        service_type="thermostat" if only_heats else _TYPE_OF[service.type],
        category="diagnostic" if service.type == _BATTERY else "",
        capabilities=tuple(one.capability for one in abilities),
    )
