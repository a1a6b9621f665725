"""The topics of one Zigbee device, and its properties as capabilities: read from messages, written into commands. Pure.

Source: zigbee2mqtt.io, Usage > MQTT topics and messages; Zigbee2MQTT 2.14.1.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial

from homebot.conventions.command_values import Writer, require_bool, require_number, require_option, require_transition
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text, is_unknown
from homebot.conventions.zigbee2mqtt.expose import SPECIFIC_TYPES, Expose, Scalar
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.numbers import finite_number

__all__ = [
    "MAX_VALUE",
    "Zigbee2MqttTopics",
    "add_enum",
    "add_flag",
    "add_number",
    "add_reader",
    "flag_of",
    "same_scalar",
    "text_of",
    "whole_or_not",
]


_MOST_SECONDS = 6_553.0
"""Longest transition that fits into a Zigbee frame: 65,535 tenths of a second, less those that mean "as you like"."""


@dataclass(frozen=True, slots=True)
class Zigbee2MqttTopics:
    """The topics of one device.

    Attributes:
        state: Topic of its state, a JSON object of all that it reports.
        is_awake: Whether it can be asked: one with a battery sleeps and never answers.
        takes_transition: Whether it takes the seconds that a change shall take.
        bare_endpoints: Numbers of its endpoints that the bridge has no name for: it does not find them in the name of a
            property, only in the topic.
        endpoint: Which of these is meant; empty for the device.
    """

    state: str
    is_awake: bool = True
    takes_transition: bool = True
    bare_endpoints: frozenset[str] = frozenset()
    endpoint: str = ""

    @property
    def command(self) -> str:
        """The topic of its commands."""
        return f"{self._base}/set"

    def of(self, expose: Expose) -> Zigbee2MqttTopics:
        """Return the topics at which *expose* is set and requested."""
        if expose.endpoint not in self.bare_endpoints:
            return self
        keys = [one.key for one in expose.features if one.key] if expose.type in SPECIFIC_TYPES else [expose.key]
        return replace(self, endpoint=expose.endpoint) if all(key.endswith(expose.suffix) for key in keys) else self

    def publish(self, message: Mapping[str, object], transition: float = 0.0) -> tuple[Publication, ...]:
        """Return what to publish to set each property of *message*.

        Args:
            message: Values by property.
            transition: Seconds that the change shall take, where the device takes that; 0 leaves it to the device.

        Raises:
            RefusedError: *transition* is out of bounds, or a text cannot be written in UTF-8.
        """
        seconds = require_transition(transition, _MOST_SECONDS)
        fields = self._plain(message)
        if seconds and self.takes_transition:
            fields["transition"] = whole_or_not(seconds)
        try:
            payload = json.dumps(fields, ensure_ascii=False, separators=(",", ":")).encode()
        except UnicodeEncodeError:
            raise RefusedError(f"a command to {self.state}", "it cannot be written in UTF-8") from None
        return (Publication(self.command, payload),)

    def request_state(self, *features: Expose | None) -> tuple[Publication, ...]:
        """Return what to publish so that the device reports *features*; nothing for those that cannot be requested."""
        keys = self._plain(_gettable(features)) if self.is_awake else {}
        if not keys:
            return ()
        payload = json.dumps(keys, ensure_ascii=False, separators=(",", ":")).encode()
        return (Publication(f"{self._base}/get", payload),)

    @property
    def _base(self) -> str:
        return f"{self.state}/{self.endpoint}" if self.endpoint else self.state

    def _plain(self, message: Mapping[str, object]) -> dict[str, object]:
        """Return *message* with properties as their endpoint knows them."""
        return {key.removesuffix(f"_{self.endpoint}"): value for key, value in message.items()}


def whole_or_not(number: float) -> float | int:
    """Return *number* as people write it: 21 rather than 21.0."""
    return int(number) if number.is_integer() else number


def _gettable(features: Iterable[Expose | None]) -> dict[str, str]:
    return {one.key: "" for one in features if one is not None and one.is_gettable}


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
    """Return what *value* of a binary says; None where it means neither yes nor no."""
    if same_scalar(value, feature.value_on):
        return True
    return False if same_scalar(value, feature.value_off) else None


def same_scalar(value: object, expected: Scalar | None) -> bool:
    """Return whether *value* is *expected*; true and 1 are two things."""
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
