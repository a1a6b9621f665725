"""The clusters of appliances: the modes that they run in, whether they run, vacuum cleaners, and car chargers. Pure.

Source: Matter 1.4 Application Clusters, 1.9 (Mode Select), 1.10 (Mode Base), 1.14 (Operational State), 7.2 to 7.4
(RVC), 8 (home appliances, among them 8.2, Temperature Control), 9.3 (Energy EVSE).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Final, NamedTuple

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.matter.endpoint import ClusterInvocation, MatterAbility, MatterEndpoint, MatterOrder
from homebot.conventions.payload import clean_text
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["appliance_abilities", "is_oven_cabinet"]

MODE_SELECT, RUN_MODE, TEMPERATURE, OPERATION, CLEANING, EVSE = 80, 84, 86, 96, 97, 153
OVEN_CAVITY, OVEN_MODE = 72, 73
_HEATER_MODE: Final = 158


class _ModeAttributes(NamedTuple):
    supported: int
    current: int


_SELECTED, _BASED = _ModeAttributes(2, 3), _ModeAttributes(0, 1)
_MODES: Final[Mapping[int, _ModeAttributes]] = {
    MODE_SELECT: _SELECTED,
    **dict.fromkeys((OVEN_MODE, 81, 82, 85, 89, 94, 157, _HEATER_MODE, 159), _BASED),
}
"""Oven, laundry washer, refrigerator, vacuum cleaner, dishwasher, microwave oven, charger, water heater, energy: an
endpoint with several is operated by the first."""

_CHANGE_TO_MODE: Final = 0
_MOST_MODES: Final = 100

_SETPOINT, _LIMITS, _LEVEL, _LEVELS = 0, (1, 2), 4, 5
_BY_NUMBER: Final = 1 << 0

_STATE: Final = 4
_STOPPED, _RUNNING, _PAUSED, _ERROR = 0, 1, 2, 3
_VACUUM_STATES: Final = {_PAUSED: "paused", _ERROR: "error", 0x40: "returning", 0x41: "docked", 0x42: "docked"}
_VACUUM_OPTIONS: Final = ("cleaning", "paused", "idle", "returning", "docked", "error")
_IDLE_TAG, _CLEANING_TAG, _MAPPING_TAG = 0x4000, 0x4001, 0x4002
_VACUUM_COMMANDS: Final = {"paused": (0, "Pause"), "returning": (128, "GoHome")}
_RESUME: Final = 3


def appliance_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield modes, and the operational state."""
    for cluster, attributes in _MODES.items():
        labels = _labels(endpoint, cluster)
        if labels and endpoint.has(cluster, attributes.current):
            settable = endpoint.accepts(cluster, _CHANGE_TO_MODE)
            name = "water_heater_mode" if cluster == _HEATER_MODE else "option"
            capability = Capability(name=name, settable=settable, options=tuple(labels.values()))
            write = partial(_write_mode, cluster, name) if settable else None
            yield MatterAbility(cluster, capability, partial(_read_mode, cluster), write)
    yield from _temperature_control(endpoint)
    for cluster in (OPERATION, OVEN_CAVITY):
        if endpoint.has(cluster, _STATE):
            yield MatterAbility(cluster, Capability(name="running"), partial(_read_state, cluster, _RUNNING))
            yield MatterAbility(cluster, Capability(name="problem"), partial(_read_state, cluster, _ERROR))
    if endpoint.has(CLEANING, _STATE) and endpoint.has(RUN_MODE, _BASED.current):
        capability = Capability(name="vacuum", settable=True, options=_VACUUM_OPTIONS)
        yield MatterAbility(CLEANING, capability, _read_vacuum, _write_vacuum, also_read=RUN_MODE)
    if endpoint.has(EVSE, 0):
        yield MatterAbility(EVSE, Capability(name="plugged_in"), _read_plugged_in)


def is_oven_cabinet(endpoint: MatterEndpoint) -> bool:
    """Return whether it is the inside of an oven; that of a refrigerator has the same device type."""
    return endpoint.has(OVEN_CAVITY) or endpoint.has(OVEN_MODE)


def _temperature_control(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield the temperature of an oven, a refrigerator or a washer, or its level: a number or a name."""
    if endpoint.features(TEMPERATURE) & _BY_NUMBER:
        bounds = tuple(one / 100 for one in map(partial(endpoint.number, TEMPERATURE), _LIMITS) if one is not None)
        bounds = bounds if len(bounds) == 2 and bounds[0] < bounds[1] else ()
        capability = Capability(name="number", settable=True, unit="°C", bounds=bounds)
        yield MatterAbility(TEMPERATURE, capability, _read_temperature, partial(_write_temperature, bounds))
    elif levels := _levels(endpoint):
        capability = Capability(name="option", settable=True, options=levels)
        yield MatterAbility(TEMPERATURE, capability, _read_temperature_level, _write_temperature_level)


def _levels(endpoint: MatterEndpoint) -> tuple[str, ...]:
    listed = endpoint.value(TEMPERATURE, _LEVELS)
    return tuple(clean_text(one) for one in listed if isinstance(one, str)) if isinstance(listed, list) else ()


def _read_temperature(endpoint: MatterEndpoint) -> PlainValue:
    hundredths = endpoint.number(TEMPERATURE, _SETPOINT)
    return None if hundredths is None else hundredths / 100


def _write_temperature(
    bounds: tuple[float, ...], _at: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    least, most = bounds or (-273.15, 327.67)
    celsius = require_number("number", value, least, most, "°C")
    return (ClusterInvocation(TEMPERATURE, "SetTemperature", {"targetTemperature": round(celsius * 100)}),)


def _read_temperature_level(endpoint: MatterEndpoint) -> PlainValue:
    levels, level = _levels(endpoint), endpoint.whole(TEMPERATURE, _LEVEL)
    return levels[level] if level is not None and 0 <= level < len(levels) else None


def _write_temperature_level(
    endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    levels = _levels(endpoint)
    level = levels.index(require_option("option", value, levels))
    return (ClusterInvocation(TEMPERATURE, "SetTemperature", {"targetTemperatureLevel": level}),)


def _modes(endpoint: MatterEndpoint, cluster: int) -> Iterator[tuple[int, str, tuple[int, ...]]]:
    """Yield number, label and standard tags of each supported mode."""
    for one in endpoint.structs(cluster, _MODES.get(cluster, _BASED).supported):
        label, mode = one.get("0", one.get("label")), one.get("1", one.get("mode"))
        tags = one.get("2", one.get("modeTags"))
        if not isinstance(label, str) or type(mode) is not int:
            continue
        listed = tags if isinstance(tags, list) else []
        values = [tag.get("1", tag.get("value")) for tag in listed if isinstance(tag, dict)]
        yield mode, clean_text(label), tuple(value for value in values if type(value) is int)


def _labels(endpoint: MatterEndpoint, cluster: int) -> dict[int, str]:
    found: dict[int, str] = {}
    for mode, label, _ in _modes(endpoint, cluster):
        if label and len(found) < _MOST_MODES:
            found[mode] = label
    return found


def _read_mode(cluster: int, endpoint: MatterEndpoint) -> PlainValue:
    mode = endpoint.whole(cluster, _MODES[cluster].current)
    return None if mode is None else _labels(endpoint, cluster).get(mode)


def _write_mode(
    cluster: int, name: str, endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    numbers = {label: mode for mode, label in _labels(endpoint, cluster).items()}
    mode = numbers[require_option(name, value, numbers)]
    return (ClusterInvocation(cluster, "ChangeToMode", {"newMode": mode}),)


def _read_state(cluster: int, wanted: int, endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(cluster, _STATE)
    return None if state is None else state == wanted


def _read_vacuum(endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(CLEANING, _STATE)
    if state in _VACUUM_STATES:
        return _VACUUM_STATES[state]
    current = endpoint.whole(RUN_MODE, _BASED.current)
    tags = next((tags for mode, _, tags in _modes(endpoint, RUN_MODE) if mode == current), ())
    if _CLEANING_TAG in tags or _MAPPING_TAG in tags:
        return "cleaning"
    return "idle" if _IDLE_TAG in tags else {_RUNNING: "cleaning", _STOPPED: "idle"}.get(-1 if state is None else state)


def _write_vacuum(
    endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    tagged = {tag: mode for mode, _, tags in reversed(list(_modes(endpoint, RUN_MODE))) for tag in tags}
    orders: dict[str, ClusterInvocation] = {
        option: ClusterInvocation(CLEANING, command)
        for option, (number, command) in _VACUUM_COMMANDS.items()
        if endpoint.accepts(CLEANING, number)
    }
    for option, tag in (("cleaning", _CLEANING_TAG), ("idle", _IDLE_TAG)):
        if tag in tagged:
            orders[option] = ClusterInvocation(RUN_MODE, "ChangeToMode", {"newMode": tagged[tag]})
    if endpoint.whole(CLEANING, _STATE) == _PAUSED and endpoint.accepts(CLEANING, _RESUME):
        orders["cleaning"] = ClusterInvocation(CLEANING, "Resume")
    return (orders[require_option("vacuum", value, orders)],)


def _read_plugged_in(endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(EVSE, 0)
    return None if state is None or state > 5 else state != 0  # 6 is a fault, which says nothing of the plug
