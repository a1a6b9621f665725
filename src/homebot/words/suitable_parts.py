"""The parts of a device that a command in words suits, each with its settings."""

from collections.abc import Iterable
from typing import TypeAlias

from homebot.devices import Device, DevicePart
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.device import is_commanded
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.words.commands import parse_command_words

ParsedSettings: TypeAlias = dict[str, PlainValue] | RefusedError
"""The values by capability for a part, or the reason why it cannot take them."""

_APPLIANCES = frozenset(
    {"fan", "robotic_vacuum_cleaner", "room_air_conditioner", "thermostat", "water_heater"}
    | {"x_alarm_panel", "x_humidifier", "x_lawn_mower"}
)
_FUNCTIONS = frozenset({"plug", "switch"})
"""Types of the parts that turn a function of an appliance on and off, such as its display or its powerful mode."""
_SETTINGS = frozenset({"x_setting"})


def settings_by_part(
    request: CommandDevicesRequest, device: Device, parts: tuple[DevicePart, ...]
) -> list[tuple[DevicePart, ParsedSettings]]:
    """Return the settings of *request* for each of *parts*, or the reason why there are none.

    Only the most suitable parts are returned. A part whose type lacks the setting is left out if another type has it: a
    speed is for the fan, and not for its lamp. Switches of a suitable appliance, such as the powerful mode of an air
    conditioner, are left out too, and so are settings, such as the sound of a television, if another part is suitable.
    """
    found: list[tuple[DevicePart, ParsedSettings]] = []
    for part in parts:
        try:
            found.append(
                (
                    part,
                    parse_command_words(
                        request.command,
                        request.values,
                        part.part,
                        part_name(device, part),
                        certain_values(device, part),
                    ),
                )
            )
        except RefusedError as exc:
            found.append((part, exc))
    able = {part.part.service_type for part, parsed in found if not isinstance(parsed, RefusedError)}
    if not able.isdisjoint(_APPLIANCES):
        able -= _FUNCTIONS
    able = able - _SETTINGS or able
    return [one for one in found if not able or (one[0].part.service_type in able and not _is_other_setting(*one))]


def certain_values(device: Device, part: DevicePart) -> dict[str, PlainValue]:
    """Return the values of *part* by capability; none if it is unreachable, or silent for long."""
    is_there = device.reachable.state != "no" and device.freshness != "stale" and part.id not in device.offline_parts
    return {one.capability: one.value.plain() for one in device.states if is_there and one.part == part.id}


def takes(request: CommandDevicesRequest, target: tuple[Device, tuple[DevicePart, ...]]) -> bool:
    """Return whether a part of *target* takes the command of *request*."""
    return any(not isinstance(parsed, RefusedError) for _, parsed in settings_by_part(request, *target))


def part_name(device: Device, part: DevicePart) -> str:
    """Return the name of *part* for people, with its id if it has no name and several parts take commands.

    The part's own name is left out if all other parts are settings or diagnostics, or none takes commands.
    """
    if part.part.name:
        is_lone = len(device.parts) == 1 or not controls(device.parts)
        is_lone = is_lone or [one for one in device.parts if not one.part.category] == [part]
        return device.name if is_lone else f"{device.name} {part.part.name}"
    others = [one for one in controls(device.parts) if one.part.service_type != "x_scene"]
    return f"{device.name} #{part.id}" if len(others) > 1 else device.name


def controls(parts: Iterable[DevicePart]) -> tuple[DevicePart, ...]:
    """Return those of *parts* that take commands."""
    return tuple(one for one in parts if is_commanded(one.part))


def _is_other_setting(part: DevicePart, parsed: ParsedSettings) -> bool:
    return part.part.service_type in _SETTINGS and isinstance(parsed, RefusedError)
