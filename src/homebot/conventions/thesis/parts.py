"""Part of a device of the thesis's layout, by the service type in its topic alone. Pure.

Source: ``docs/house.md``, the table of devices. A word with several meanings means what can be commanded, because
every device of the layout takes commands: ``windows`` are windows with a motor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from homebot.devices.device_types import wanted_types
from homebot.devices.part import Capability, Part

__all__ = ["thesis_part"]


@dataclass(frozen=True, slots=True)
class _ServiceTypeKind:
    """The capabilities of devices of one type: those that they report and take, and those that they only report."""

    settable: tuple[str, ...] = ()
    readable: tuple[str, ...] = ()
    tag: str = ""


_OPENING = ("movement", "position")

_KINDS: Mapping[str, _ServiceTypeKind] = {
    "light": _ServiceTypeKind(("on_off", "level", "color_temperature")),
    "plug": _ServiceTypeKind(("on_off",)),
    "switch": _ServiceTypeKind(("on_off",)),
    "siren": _ServiceTypeKind(("on_off",)),
    "pump": _ServiceTypeKind(("on_off",)),
    "fan": _ServiceTypeKind(("on_off", "fan_speed")),
    "window_covering": _ServiceTypeKind(_OPENING),
    "closure": _ServiceTypeKind(_OPENING),
    "door_lock": _ServiceTypeKind(("lock",)),
    "water_valve": _ServiceTypeKind(("valve", "position")),
    "thermostat": _ServiceTypeKind(("heating_setpoint",), ("local_temperature",)),
    "contact_sensor": _ServiceTypeKind((), ("contact",)),
    "occupancy_sensor": _ServiceTypeKind((), ("occupancy",)),
    "temperature_sensor": _ServiceTypeKind((), ("temperature",)),
    "humidity_sensor": _ServiceTypeKind((), ("humidity",)),
    "light_sensor": _ServiceTypeKind((), ("illuminance",)),
    "pressure_sensor": _ServiceTypeKind((), ("pressure",)),
    "flow_sensor": _ServiceTypeKind((), ("flow",)),
    "soil_sensor": _ServiceTypeKind((), ("soil_moisture",)),
    "smoke_co_alarm": _ServiceTypeKind((), ("smoke",)),
    "water_leak_detector": _ServiceTypeKind((), ("water_leak",)),
    "rain_sensor": _ServiceTypeKind((), ("rain",)),
    "water_freeze_detector": _ServiceTypeKind((), ("freeze",)),
    "electrical_meter": _ServiceTypeKind((), ("power",)),
    "x_battery": _ServiceTypeKind((), ("battery",)),
    "x_robot": _ServiceTypeKind((), ("value",)),
    "x_tracker": _ServiceTypeKind((), ("place",)),
    "x_sensor": _ServiceTypeKind((), ("value",)),
    "x_binary_sensor": _ServiceTypeKind((), ("state",)),
}

_CLEARED: Mapping[frozenset[str], tuple[str, str]] = {
    wanted_types("window"): ("closure", "window"),
    wanted_types("door"): ("closure", "door"),
    wanted_types("climate"): ("thermostat", ""),
}
"""Type and tag of what may mean several things."""


def thesis_part(service_type: str, address: str, command_address: str) -> Part:
    """Return what a device is that calls itself *service_type*; without a type for a word that means none of these.

    Args:
        service_type: As it stands in the topic, for example ``lights``.
        address: The topic on which the device publishes.
        command_address: The topic on which it takes commands.
    """
    name, tag, capabilities = _found(service_type)
    takes_commands = any(one.settable for one in capabilities)
    return Part(
        id="",
        service_type=name,
        advertised=service_type,
        tag=tag,
        guessed=True,
        capabilities=capabilities,
        reads=(address,),
        writes=(command_address,) if takes_commands else (),
    )


@lru_cache(maxsize=1000)
def _found(service_type: str) -> tuple[str, str, tuple[Capability, ...]]:
    meant = wanted_types(service_type)
    name, tag = _CLEARED.get(meant, (next(iter(meant)) if len(meant) == 1 else "", ""))
    if tag == "door" and "garage" in service_type.casefold():
        tag = "garage_door"
    kind = _KINDS.get(name)
    if kind is None:
        return "", "", ()
    settable = tuple(Capability(name=one, settable=True) for one in kind.settable)
    return name, tag, settable + tuple(Capability(name=one) for one in kind.readable)
