"""Values that users or makers of a device define themselves, in Shelly's second generation. Pure.

Source: Shelly Gen2+ API, Virtual Components: Boolean, Number, Text, Enum and Button; XT1, Irrigation Controller and
Smart Water Valve; ShellyX, Manifest Reference.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from homebot.conventions.command_values import (
    option_writer,
    push_writer,
    require_bool,
    require_number,
    require_option,
)
from homebot.conventions.description import Publications
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, clean_text, percent_of, shown, text_of
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent
from homebot.conventions.units import sensor_type
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.numbers import to_number

__all__ = ["VIRTUAL", "build_virtual", "build_virtual_button"]

VIRTUAL: Mapping[str, str] = {"boolean": "state", "number": "number", "text": "text", "enum": "option"}
"""The capability of each kind."""

_MOST = 1e15
_LONGEST_TEXT = 255
_LONGEST_UNIT = 20
_MOST_OPTIONS = 100


def build_virtual(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a value as a setting, or as what its role or its access says."""
    role = _role(component.config)
    if component.kind == "boolean" and _ZONE.fullmatch(role):
        return (_build_zone(component),)
    if component.kind == "number" and role == _POSITION:
        return (_build_valve(component),)
    access = component.config.get("access")
    if (role in _WATCHED and component.kind == "number") or (isinstance(access, str) and "w" not in access):
        return (_build_watched(component, role),)
    is_number = component.kind == "number"
    own = _CONTROLLED.get((component.kind, role))
    service_type, capability = own or ("x_setting", VIRTUAL[component.kind])
    options = _options(component.config)
    bounds = _bounds(component.config)
    least, most = bounds or (-_MOST, _MOST)

    def decode(status: Fields) -> Readings:
        value = _plain(component.kind, status.get("value"))
        return NO_READINGS if value is None else {capability: value}

    def write(value: PlainValue, _transition: float) -> Publications:
        method = f"{component.kind.capitalize()}.Set"
        match component.kind:
            case "boolean":
                return component.call(method, value=require_bool(capability, value))
            case "number":
                number = require_number(capability, value, least, most)
                return component.call(method, value=int(number) if number.is_integer() else number)
            case "enum" if options:
                return component.call(method, value=require_option(capability, value, options))
            case _:
                return component.call(method, value=_require_text(capability, value))

    part = component.part("", service_type, category="config" if service_type == "x_setting" else "")
    component.read_status(part, decode)
    component.add_command_topic(part)
    part.add_capability(
        capability,
        writer=write,
        unit=_unit(component.config) if capability == "number" else "",
        bounds=bounds if is_number else (),
        options=options if component.kind == "enum" else (),
    )
    return (part,)


def _build_zone(component: ShellyComponent) -> JsonPart:
    """Describe a zone of an irrigation controller: a valve that is open while the zone is watered."""

    def decode(status: Fields) -> Readings:
        value = status.get("value")
        return {"valve": "open" if value else "closed"} if isinstance(value, bool) else NO_READINGS

    part = component.part("", "water_valve", tag=_role(component.config))
    component.read_status(part, decode)
    component.add_command_topic(part)
    writer = option_writer("valve", _VALVES, lambda state: component.call("Boolean.Set", value=state == "open"))
    part.add_capability("valve", writer=writer, options=_VALVES)
    return part


def _build_valve(component: ShellyComponent) -> JsonPart:
    """Describe a water valve that can be opened in part."""

    def decode(status: Fields) -> Readings:
        percent = percent_of(status.get("value"))
        return NO_READINGS if percent is None else {"position": percent, "valve": "open" if percent else "closed"}

    def move(value: PlainValue, _transition: float) -> Publications:
        return component.call("Number.Set", value=round(require_number("position", value, 0.0, 100.0, "%")))

    part = component.part("", "water_valve", tag=_role(component.config))
    component.read_status(part, decode)
    component.add_command_topic(part)
    writer = option_writer("valve", _VALVES, lambda state: move(100.0 if state == "open" else 0.0, 0.0))
    part.add_capability("valve", writer=writer, options=_VALVES)
    part.add_capability("position", writer=move)
    return part


def _build_watched(component: ShellyComponent, role: str) -> JsonPart:
    """Describe a value that is only reported."""
    plain = _READ_ONLY[component.kind]
    own_unit = _unit(component.config) if plain == "measurement" else ""
    capability, unit = _WATCHED.get(role if component.kind == "number" else "", (plain, own_unit))

    def decode(status: Fields) -> Readings:
        value = _plain(component.kind, status.get("value"))
        return NO_READINGS if value is None else {capability: value}

    part = component.part("", sensor_type(capability))
    component.read_status(part, decode)
    part.add_capability(capability, unit=unit)
    return part


_VALVES = ("open", "closed")
_ZONE = re.compile(r"zone[0-9]{1,2}")
_READ_ONLY: Mapping[str, str] = {"boolean": "state", "number": "measurement", "text": "value", "enum": "value"}
_WATCHED: Mapping[str, tuple[str, str]] = {
    "average_temperature": ("temperature", ""),
    "last_precipitation": ("measurement", "mm"),
    "current_temperature": ("temperature", ""),
    "current_humidity": ("humidity", ""),
}
"""Capabilities of the numbers of a maker's service, by their roles."""


_POSITION = "position"
"""Role of the number of a maker's service that is how far a water valve is open; blinds are covers there."""

_CONTROLLED: Mapping[tuple[str, str], tuple[str, str]] = {
    ("number", "target_temperature"): ("thermostat", "heating_setpoint"),
    ("number", "target_humidity"): ("x_humidifier", "humidity_setpoint"),
    ("boolean", "state"): ("switch", "on_off"),
}
"""Types and capabilities of what people set in a maker's service, by kind and role."""


def _role(config: Fields) -> str:
    """Return the meaning that a maker's service gives the value; empty for a user's own."""
    owner, role = config.get("owner"), config.get("role")
    is_makers = isinstance(owner, str) and owner.startswith("service:")
    return role if is_makers and isinstance(role, str) else ""


def build_virtual_button(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a button that can be pressed by command."""
    part = component.part("", "generic_switch")
    component.add_command_topic(part)
    part.add_capability(
        "push",
        readable=False,
        writer=push_writer("push", lambda: component.call("Button.Trigger", event="single_push")),
    )
    return (part,)


def _plain(kind: str, value: object) -> PlainValue:
    if kind == "number":
        return to_number(value)
    if kind == "boolean":
        return value if isinstance(value, bool) else None
    return clean_text(value, _LONGEST_TEXT) if isinstance(value, str) else None


def _require_text(capability: str, value: PlainValue) -> str:
    if isinstance(value, str) and len(value) <= _LONGEST_TEXT and value.isprintable():
        return value
    raise RefusedError(f"{capability} {shown(value)}", f"it takes a text of at most {_LONGEST_TEXT} characters")


def _options(config: Fields) -> tuple[str, ...]:
    options = config.get("options")
    if not isinstance(options, list):
        return ()
    return tuple(one for one in options[:_MOST_OPTIONS] if isinstance(one, str) and len(one) <= _LONGEST_TEXT)


def _unit(config: Fields) -> str:
    """Return the unit in which the device's own pages show a number; empty where it has none."""
    unit = as_fields(as_fields(config.get("meta")).get("ui")).get("unit")
    return text_of(unit, _LONGEST_UNIT)


def _bounds(config: Fields) -> tuple[float, ...]:
    least, most = to_number(config.get("min")), to_number(config.get("max"))
    return (least, most) if least is not None and most is not None and least < most else ()
