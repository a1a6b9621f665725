"""The parts that an endpoint of a Matter node is. Pure.

The tables of device types are the vocabulary's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from homebot.conventions.matter.appliance_clusters import appliance_abilities, is_oven_cabinet
from homebot.conventions.matter.climate_clusters import climate_abilities
from homebot.conventions.matter.closure_clusters import closure_abilities
from homebot.conventions.matter.endpoint import MatterAbility, MatterEndpoint
from homebot.conventions.matter.endpoint_name import name_of
from homebot.conventions.matter.light_clusters import light_abilities
from homebot.conventions.matter.opening_clusters import opening_abilities
from homebot.conventions.matter.other_clusters import other_abilities
from homebot.conventions.matter.sensor_clusters import BATTERY, sensor_abilities
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Part

__all__ = ["find_abilities", "parts_of"]

_SERVICE_TYPES: Final[Mapping[int, str]] = {number: one.name for one in DEVICE_TYPES.values() for number in one.matter}
_METERS: Final = frozenset({"electrical_meter"})
_CAPABILITY_TYPES: Final = {
    "occupancy": "occupancy_sensor",
    "movement": "closure",
    "position": "closure",
    "tilt": "closure",
    "number": "x_setting",
    "option": "x_setting",  # of an appliance too: a command to turn all switches off must not stop a freezer
    "on_off": "switch",
    "press": "generic_switch",
    "power": "electrical_meter",
    "energy": "electrical_meter",
    "temperature": "temperature_sensor",
    "humidity": "humidity_sensor",
}
"""By capability: the type of an endpoint with unknown device types."""

_COOKERS: Final = {0x0077: "cooktop", 0x0078: "cooktop", 0x0079: "microwave oven", 0x007B: "oven"}
"""By device type: devices that have no type in the vocabulary and get hot, under the names of people and policies."""

_FINDERS: Final = (
    light_abilities,
    opening_abilities,
    closure_abilities,
    climate_abilities,
    appliance_abilities,
    sensor_abilities,
    other_abilities,
)


def parts_of(endpoint: MatterEndpoint, *, covers: bool = False) -> Iterator[tuple[Part, tuple[MatterAbility, ...]]]:
    """Yield the parts of an endpoint: its main function, and beside that its battery and plain measurements.

    Args:
        endpoint: The endpoint.
        covers: Whether a closure is a blind, or a panel of one.
    """
    abilities = tuple(find_abilities(endpoint))
    main = tuple(one for one in abilities if not one.beside)
    if any(one.read is not None or one.capability.name == "press" for one in main):
        service_type, is_guessed = _service_type(endpoint, main)
        service_type = "window_covering" if covers and service_type == "closure" else service_type
        capabilities = tuple(one.capability for one in main)
        yield (
            Part(
                id=str(endpoint.id),
                name=name_of(endpoint),
                service_type=service_type,
                advertised=_advertised(endpoint),
                guessed=is_guessed,
                capabilities=capabilities,
            ),
            main,
        )
    for beside in dict.fromkeys(one.beside for one in abilities if one.beside):
        found = tuple(one for one in abilities if one.beside == beside)
        is_battery = beside == BATTERY
        part = Part(
            id=f"{endpoint.id}-{beside}",
            name="" if is_battery else beside.replace("_", " ").capitalize(),
            service_type="x_battery" if is_battery else "air_quality_sensor",
            category="diagnostic" if is_battery else "",
            capabilities=tuple(one.capability for one in found),
        )
        yield part, found


def find_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield everything that an endpoint can do and report, each capability of a part once."""
    seen: set[tuple[str, str]] = set()
    for find in _FINDERS:
        for ability in find(endpoint):
            name = (ability.beside, ability.capability.name)
            if name not in seen:
                seen.add(name)
                yield ability


def _advertised(endpoint: MatterEndpoint) -> str:
    """Return the device types, with the word for a hot device: the cabinet of an oven is known by its clusters."""
    types = endpoint.device_types[:5]
    text = ", ".join(f"0x{one:04X}" for one in types)
    hot = next((_COOKERS[one] for one in types if one in _COOKERS), "oven" if is_oven_cabinet(endpoint) else "")
    return f"{text} ({hot})" if hot else text


def _service_type(endpoint: MatterEndpoint, abilities: tuple[MatterAbility, ...]) -> tuple[str, bool]:
    """Return the type of a part, and whether it is guessed; a meter only where it is nothing else."""
    found = [_SERVICE_TYPES[one] for one in endpoint.device_types if one in _SERVICE_TYPES]
    for one in (*(one for one in found if one not in _METERS), *found):
        return one, False
    names = [one.capability.name for one in abilities]
    return next((kind for name, kind in _CAPABILITY_TYPES.items() if name in names), "x_sensor"), True
