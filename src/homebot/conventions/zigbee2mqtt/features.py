"""One property of a Zigbee device as a capability: read from its messages, written into its commands. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings, is_unknown
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import clean_text
from homebot.conventions.table_codec import Writer
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics, whole_or_not
from homebot.conventions.zigbee2mqtt.expose import Expose, Scalar
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = [
    "MAX_VALUE",
    "add_enum",
    "add_flag",
    "add_number",
    "add_reader",
    "flag_of",
    "same_scalar",
    "text_of",
]

MAX_VALUE = 255
"""Longest text that is read from a device."""

_NO_BOUND = 1e12


def add_reader(
    part: JsonPart, topics: Zigbee2MqttTopics, feature: Expose, capability: str, read: Callable[[object], PlainValue]
) -> None:
    """Have *part* read the property of *feature*; null is unknown, and so is what says that of a number.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        feature: What to read.
        capability: What it is then.
        read: Returns what a value means, None where it means nothing.
    """
    is_number = CAPABILITIES[capability].kind == "number"
    part.read_from(topics.state, partial(_read, feature.key, capability, read, is_unknown if is_number else _is_null))


def add_flag(part: JsonPart, topics: Zigbee2MqttTopics, feature: Expose | None, capability: str) -> None:
    """Have *part* offer a binary *feature* as *capability*: true is what its ``value_on`` says."""
    if feature is None or feature.value_on is None or feature.value_off is None:
        return
    if feature.is_published:
        add_reader(part, topics, feature, capability, partial(flag_of, feature))
    writer = partial(_write_flag, topics, feature, capability) if feature.is_settable else None
    part.add_capability(capability, readable=feature.is_published, writer=writer)
    _connect(part, topics, feature)


def add_number(
    part: JsonPart, topics: Zigbee2MqttTopics, feature: Expose | None, capability: str, *, unit: str = ""
) -> None:
    """Have *part* offer a numeric *feature* as *capability*, in the same unit."""
    if feature is None:
        return
    if feature.is_published:
        add_reader(part, topics, feature, capability, finite_number)
    bounds = () if feature.least is None or feature.most is None else (feature.least, feature.most)
    writer = partial(_write_number, topics, feature, capability) if feature.is_settable else None
    part.add_capability(capability, readable=feature.is_published, writer=writer, unit=unit, bounds=bounds)
    _connect(part, topics, feature)


def add_enum(
    part: JsonPart,
    topics: Zigbee2MqttTopics,
    feature: Expose | None,
    capability: str,
    names: Mapping[str, str] | None = None,
) -> None:
    """Have *part* offer an enum *feature* as *capability*.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        feature: The enum; None does nothing.
        capability: What it is.
        names: The vocabulary's word for each of the device's; others mean nothing. By default all as they are.
    """
    if feature is None:
        return
    if feature.is_published:
        add_reader(part, topics, feature, capability, text_of if names is None else partial(_name_of, names))
    writer: Writer | None = partial(_write_option, topics, feature, capability) if feature.is_settable else None
    options = tuple(feature.options) if names is None else tuple(names.values())
    part.add_capability(capability, readable=feature.is_published, writer=writer, options=options)
    _connect(part, topics, feature)


def flag_of(feature: Expose, value: object) -> bool | None:
    """Return what *value* of a binary says; None where it says neither yes nor no."""
    if same_scalar(value, feature.value_on):
        return True
    return False if same_scalar(value, feature.value_off) else None


def same_scalar(value: object, expected: Scalar | None) -> bool:
    """Tell whether *value* is *expected*; true and 1 are two things."""
    return isinstance(value, bool) == isinstance(expected, bool) and value == expected


def text_of(value: object) -> str | None:
    """Return a short text or number as text; None for what is neither."""
    if isinstance(value, str):
        return clean_text(value, MAX_VALUE)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)) and finite_number(value) is not None:
        return str(value)
    return None


def _connect(part: JsonPart, topics: Zigbee2MqttTopics, feature: Expose) -> None:
    if feature.is_settable:
        part.add_command_topics(topics.command)


def _is_null(value: object) -> bool:
    return value is None


def _read(
    key: str,
    capability: str,
    read: Callable[[object], PlainValue],
    means_unknown: Callable[[object], bool],
    message: JsonMessage,
) -> Readings:
    if key not in message:
        return NO_READINGS
    value = message[key]
    if means_unknown(value):
        return {capability: None}
    found = read(value)
    return NO_READINGS if found is None else {capability: found}


def _name_of(names: Mapping[str, str], value: object) -> str | None:
    return names.get(value) if isinstance(value, str) else None


def _write_flag(
    topics: Zigbee2MqttTopics, feature: Expose, capability: str, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    state = feature.value_on if require_bool(capability, value) else feature.value_off
    return topics.publish({feature.key: state})


def _write_number(
    topics: Zigbee2MqttTopics, feature: Expose, capability: str, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    least = -_NO_BOUND if feature.least is None else feature.least
    most = _NO_BOUND if feature.most is None else feature.most
    number = require_number(capability, value, least, most, feature.unit)
    return topics.publish({feature.key: whole_or_not(number)})


def _write_option(
    topics: Zigbee2MqttTopics, feature: Expose, capability: str, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    option = require_option(capability, value, feature.options)
    return topics.publish({feature.key: feature.options[option]})
