"""Values of a Zigbee device beside its main parts: sensors, buttons and settings. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > Generic; zigbee-herdsman-converters 26.105.0 for the names in use.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from homebot.conventions.command_values import push_writer
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text, shown
from homebot.conventions.secrets import names_secret
from homebot.conventions.units import Quantity, conversion_of, sensor_type
from homebot.devices.capabilities import MEASURED
from homebot.devices.part import Category
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.zigbee2mqtt.formats.expose import Expose
from homebot.integrations.zigbee2mqtt.formats.features import (
    MAX_VALUE,
    Zigbee2MqttPart,
    Zigbee2MqttTopics,
    read_finite,
    text_of,
)

_CONDITION_NAMES: Mapping[str, tuple[str, ...]] = {
    "contact": ("contact", "garage_door_contact", "window", "window_open", "valve_state"),
    "occupancy": ("occupancy", "presence", *(f"area{number}Occupancy" for number in range(1, 5))),
    "smoke": ("smoke",),
    "carbon_monoxide_alarm": ("carbon_monoxide",),
    "gas": ("gas",),
    "water_leak": ("water_leak", "active_water_leak", "water", "water_sensor"),
    "rain": ("rain", "rain_status"),
    "battery_low": ("battery_low",),
    "battery_charging": ("is_charging",),
    "tamper": ("tamper", "tamper_alarm"),
    "vibration": ("vibration",),
    "heat": ("heat",),
    "sound": ("noise_detected", "noise"),
    "moving": ("moving",),
    "running": ("running",),
    "problem": ("valve_alarm", "fault", "fault_alarm", "motor_fault", "trouble"),
    "safety": ("sos",),
    "plugged_in": ("consumer_connected", "is_plug_connected"),
}
_CONDITIONS: Mapping[str, str] = {name: capability for capability, names in _CONDITION_NAMES.items() for name in names}
"""Capability of a read-only binary; true is its ``value_on``."""

_DETECTORS = {"battery_charging": "x_battery", "heat": "smoke_co_alarm"}
"""Service type by capability, where it is not that of any sensor of it: ``heat`` is told by fire detectors."""

_ALARM_OF_ZONE = re.compile(r"(contact|occupancy|smoke|carbon_monoxide|gas|water_leak|vibration|tamper)_alarm_[12]")
"""A binary of a detector with two alarms; each means the same as a single one."""

_RADAR = "presence"
"""The binary of radars, such as Tuya's ZY-M100; motion sensors report ``occupancy``."""

_TRUE_IS_CLOSED = frozenset({"garage_door_contact"})
"""Binaries with an inverted ``value_on``: they report a closed contact."""


def _quantity_of(name: str, unit: str) -> Quantity:
    """Return the quantity of the number *name* in *unit*; a plain measurement if it is not certain."""
    capability = _NAMES.get(name) or _capability_of(name, unit)
    conversion = conversion_of(capability, unit) if capability else None
    if conversion is None:
        return Quantity(_SERVICES_OF_PLAIN.get(name, "x_sensor"), "measurement", unit)
    return Quantity(sensor_type(capability), capability, "", conversion)


_AIR = "air_quality_sensor"

_NAMES: Mapping[str, str] = {
    "EAIT": "energy_returned",
    "ambient_light": "illuminance",
    "aqi": "air_quality_index",
    **dict.fromkeys(("battery2", "battery_life", "battery_value", "battpercentage"), "battery"),
    **dict.fromkeys(("co", "co_ppm", "carbon_monoxide_value"), "carbon_monoxide"),
    "co2": "carbon_dioxide",
    **dict.fromkeys(("flow_rate", "instantaneous_flow_rate"), "flow"),
    "moisture": "soil_moisture",
    **dict.fromkeys(("air_temp", "dew_point", "floor_temp", "humidex", "wind_chill"), "temperature"),
    "voc": "volatile_organic_compounds",
}
_SERVICES_OF_PLAIN: Mapping[str, str] = {"voc": _AIR, "eco2": _AIR, "voc_index": _AIR}

_BY_UNIT_ALONE = ("power", "energy", "current", "voltage", "frequency")
_BY_NAME = ("temperature", "humidity")
_RETURNED = frozenset({"output", "produced", "reverse"})
_NO_READINGS = frozenset(
    {"limit", "setpoint", "target", "calibration", "offset", "max", "min", "threshold", "alarm", "deadzone"}
)
"""Words in the names of settings, which are not measured."""


def _capability_of(name: str, unit: str) -> str:
    """Return the capability: electrical units identify it, other units only together with the name."""
    tokens = set(re.split(r"[^a-z]+", re.sub(r"([A-Z])", r"_\1", name).lower()))
    for capability in _BY_UNIT_ALONE:
        if conversion_of(capability, unit) is not None:
            return "energy_returned" if capability == "energy" and tokens & _RETURNED else capability
    if tokens & _NO_READINGS:
        return ""
    return name if name in MEASURED else next((word for word in _BY_NAME if word in tokens), "")


def build_generic(topics: Zigbee2MqttTopics, expose: Expose) -> DescribedPart | None:
    """Describe one generic expose as a part of its own; None if it is neither published nor settable.

    Anything settable is a setting, also a child lock, which is no door lock, or an indicator, which stays on when all
    lamps are turned off. Only a binary named ``state`` is a switch. A code or password may be set, but never read.
    """
    if expose.type == "enum" and expose.name == "action":
        buttons = Zigbee2MqttPart.of(topics, expose, "generic_switch")
        buttons.read_events_from(topics.state, partial(_read_action, expose.key))
        buttons.add_capability("press", options=tuple(expose.options))
        return buttons.build()
    if _is_secret(expose):
        expose = replace(expose, access=expose.access & ~_IS_READ)
    part = _setting(topics, expose) if expose.is_settable else _sensor(topics, expose) if expose.is_published else None
    return None if part is None or part.is_empty else part.build()


def _is_secret(expose: Expose) -> bool:
    """Return whether *expose*, or one of its features, is a code or password."""
    return names_secret(expose.name) or any(map(_is_secret, expose.features))


_IS_READ = 1 | 4


def _read_action(key: str, message: JsonMessage) -> Readings:
    """Read an action; an empty one only ends the last one."""
    action = message.get(key)
    return {"press": clean_text(action, MAX_VALUE)} if isinstance(action, str) and action else NO_READINGS


def _sensor(topics: Zigbee2MqttTopics, expose: Expose) -> Zigbee2MqttPart:
    category: Category = "diagnostic" if expose.category else ""
    if expose.type == "binary":
        zone = _ALARM_OF_ZONE.fullmatch(expose.name)
        capability = _CONDITIONS.get(zone[1] if zone else expose.name, "state")
        service_type = _DETECTORS.get(capability) or sensor_type(capability)
        if expose.name in _TRUE_IS_CLOSED:
            expose = replace(expose, value_on=False, value_off=True)
        tag = expose.name if expose.name == _RADAR else ""
        part = Zigbee2MqttPart.of(topics, expose, service_type, category, tag)
        part.add_flag(expose, capability)
    elif expose.type == "numeric":
        quantity = _quantity_of(expose.name, expose.unit)
        part = Zigbee2MqttPart.of(topics, expose, quantity.service_type, category)
        part.read_feature(expose, quantity.capability, partial(_measured, quantity))
        part.add_capability(quantity.capability, unit=quantity.unit)
    else:
        part = Zigbee2MqttPart.of(topics, expose, "x_sensor", category)
        part.read_feature(expose, "value", text_of if expose.type == "enum" else _json_text)
        part.add_capability("value", options=tuple(expose.options))
    if not category:
        part.request(expose)
    return part


def _setting(topics: Zigbee2MqttTopics, expose: Expose) -> Zigbee2MqttPart | None:
    if (expose.type, expose.name, expose.category) == ("binary", "state", ""):
        part = Zigbee2MqttPart.of(topics, expose, "switch")
        part.add_flag(expose, "on_off")
        part.request(expose)
        return part
    part = Zigbee2MqttPart.of(topics, expose, "x_setting", expose.category or "config")
    match expose.type:
        case "binary":
            part.add_flag(expose, "on_off")
        case "numeric":
            part.add_number(expose, "number", unit=expose.unit)
        case "enum":
            values = list(expose.options.values())
            actions = [value for value in values if value != ""] or values  # a feeder reports it while it is idle
            if len(actions) != 1:
                part.add_enum(expose, "option")
            else:
                push = "locate" if expose.name == "identify" else "push"
                writer = push_writer(push, lambda: part.topics.publish({expose.key: actions[0]}))
                part.add_capability(push, readable=False, writer=writer)
        case "text":
            part.add_feature(expose, "text", _json_text, partial(_write_text, topics, expose))
        case _:
            return _sensor(topics, expose) if expose.is_published else None
    return part


_MAX_TEXT = 4_096


def _measured(quantity: Quantity, value: object) -> float | None:
    number = read_finite(value)
    return None if number is None else quantity.value(number)


def _json_text(value: object) -> str:
    """Return *value* as text; a list or an object as JSON, cut."""
    text = text_of(value)
    return clean_text(json.dumps(value, ensure_ascii=False), MAX_VALUE) if text is None else text


def _write_text(topics: Zigbee2MqttTopics, expose: Expose, value: PlainValue, _transition: float) -> Publications:
    if not isinstance(value, str) or len(value) > _MAX_TEXT:
        raise RefusedError(f"text {shown(value)}", f"it takes a text of at most {_MAX_TEXT} characters")
    return topics.publish({expose.key: value})
