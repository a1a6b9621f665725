"""The topics of one Zigbee device, and its properties as capabilities: read from messages, written into commands. Pure.

Source: zigbee2mqtt.io, Usage > MQTT topics and messages; Zigbee2MQTT 2.14.1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Unpack

from homebot.conventions.command_values import Writer, bool_writer, number_writer, option_writer, require_transition
from homebot.conventions.description import Publication, Publications
from homebot.conventions.part_builder import CapabilityFields, JsonPart, PartFields
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text, compact_json, is_unknown
from homebot.conventions.table_codec import write_one_object
from homebot.conventions.units import number_grid
from homebot.conventions.unreadable import unreadable
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Category
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.zigbee2mqtt.formats.expose import SPECIFIC_TYPES, Expose, Scalar
from homebot.support.numbers import finite_number

_MAX_TRANSITION_S = 6_553.0
"""Longest transition in a Zigbee frame: 65,535 tenths of a second, without the reserved values."""


@dataclass(frozen=True, slots=True)
class Zigbee2MqttTopics:
    """The topics of one device.

    Attributes:
        state: The topic of its state, one JSON object.
        is_awake: Whether it answers requests; a device with a battery sleeps.
        bare_endpoints: Numbers of its endpoints without a name, which the bridge only finds in the topic, not in the
            name of a property.
        endpoint: One of these; empty for the device.
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
        """Return the topics of *expose*."""
        if expose.endpoint not in self.bare_endpoints:
            return self
        keys = (
            [feature.key for feature in expose.features if feature.key]
            if expose.type in SPECIFIC_TYPES
            else [expose.key]
        )
        return replace(self, endpoint=expose.endpoint) if all(key.endswith(expose.suffix) for key in keys) else self

    def publish(self, message: Mapping[str, object], transition: float = 0.0) -> Publications:
        """Return the command that sets each property of *message*.

        Args:
            transition: Seconds; 0 leaves it to the device.

        Raises:
            RefusedError: *transition* is out of bounds, or a text cannot be encoded as UTF-8.
        """
        seconds = require_transition(transition, _MAX_TRANSITION_S)
        fields = self._plain(message)
        if seconds:
            fields["transition"] = _whole_or_not(seconds)
        try:
            payload = compact_json(fields).encode()
        except UnicodeEncodeError:
            raise RefusedError(f"a command to {self.state}", "it cannot be encoded as UTF-8") from None
        return (Publication(self.command, payload),)

    def request_state(self, *features: Expose | None) -> Publications:
        """Return the request of *features*; empty if none can be requested."""
        gettable = [feature.key for feature in features if feature is not None and feature.is_gettable]
        if not (gettable and self.is_awake):
            return ()
        return (Publication(f"{self._base}/get", compact_json(self._plain(dict.fromkeys(gettable, ""))).encode()),)

    @property
    def _base(self) -> str:
        return f"{self.state}/{self.endpoint}" if self.endpoint else self.state

    def _plain(self, message: Mapping[str, object]) -> dict[str, object]:
        """Return *message* without the suffix of the endpoint."""
        return {key.removesuffix(f"_{self.endpoint}"): value for key, value in message.items()}


def _whole_or_not(number: float) -> float | int:
    """Return *number* without a fraction of zero: 21, not 21.0."""
    return int(number) if number.is_integer() else number


MAX_VALUE = 255
"""Longest text that is read from a device."""

_NO_BOUND = 1e12


class Zigbee2MqttPart(JsonPart):
    """A part of a Zigbee device, with features as its capabilities."""

    joint = staticmethod(write_one_object)

    def __init__(
        self, topics: Zigbee2MqttTopics, part_id: str, service_type: str, **fields: Unpack[PartFields]
    ) -> None:
        super().__init__(part_id, service_type, commands=topics.command, **fields)
        self.topics = topics

    @classmethod
    def of(
        cls, topics: Zigbee2MqttTopics, expose: Expose, service_type: str, category: Category = "", tag: str = ""
    ) -> Zigbee2MqttPart:
        """Return the part of a generic *expose*."""
        part_id, name = clean_text(expose.key), expose.name
        return cls(topics, part_id, service_type, name=expose.title, advertised=name, category=category, tag=tag)

    def read_feature(self, feature: Expose, capability: str, meaning: Callable[[object], PlainValue]) -> None:
        """Read the property of *feature*; *meaning* returns None for no value, and null is unknown."""
        self.read_from(self.topics.state, partial(_read, feature.key, capability, meaning))

    def add_feature(
        self,
        feature: Expose,
        capability: str,
        meaning: Callable[[object], PlainValue],
        writer: Writer | None,
        **fields: Unpack[CapabilityFields],
    ) -> None:
        """Add *capability* from *feature*: readable if it is published, settable with a *writer*."""
        readable = feature.is_published
        if readable:
            self.read_feature(feature, capability, meaning)
        self.add_capability(capability, readable=readable, writer=writer, **fields)

    def add_flag(self, feature: Expose | None, capability: str) -> None:
        """Add a boolean *capability* from a binary *feature*: true is its ``value_on``."""
        if feature is None or feature.value_on is None or feature.value_off is None:
            return
        payloads = {True: feature.value_on, False: feature.value_off}
        writer = None
        if feature.is_settable:
            writer = bool_writer(capability, lambda on: self.topics.publish({feature.key: payloads[on]}))
        self.add_feature(feature, capability, partial(flag_of, feature), writer)

    def state_writer(self, feature: Expose, capability: str, targets: Mapping[str, Scalar | None]) -> Writer:
        """Return the writer of *capability* by the values of a binary *feature*, one for each of the *targets*."""
        return option_writer(capability, targets, lambda target: self.topics.publish({feature.key: targets[target]}))

    def add_number(self, feature: Expose | None, capability: str, *, unit: str = "") -> None:
        """Add *capability* from a numeric *feature*, in the same unit."""
        if feature is None:
            return
        least = -_NO_BOUND if feature.least is None else feature.least
        most = _NO_BOUND if feature.most is None else feature.most
        writer = None
        if feature.is_settable:
            writer = number_writer(
                capability,
                (least, most),
                feature.unit,
                lambda number: self.topics.publish({feature.key: _whole_or_not(number)}),
            )
        bounds = () if feature.least is None or feature.most is None else (least, most)
        grid = number_grid(feature.least, feature.step)
        self.add_feature(feature, capability, read_finite, writer, unit=unit, bounds=bounds, grid=grid)

    def add_enum(self, feature: Expose | None, capability: str, names: Mapping[str, str] | None = None) -> None:
        """Add *capability* from an enum *feature*, or a reported one with the vocabulary's *names* of its values."""
        if feature is None:
            return
        writer = None
        if feature.is_settable and names is None:
            writer = option_writer(
                capability, feature.options, lambda option: self.topics.publish({feature.key: feature.options[option]})
            )
        meaning = text_of if names is None else partial(_name_of, names)
        options = tuple(feature.options if names is None else names.values())
        self.add_feature(feature, capability, meaning, writer, options=options)

    def request(self, *features: Expose | None) -> None:
        """Add the request of *features*; see :meth:`Zigbee2MqttTopics.request_state`."""
        self.add_state_request(*self.topics.request_state(*features))


def flag_of(feature: Expose, value: object) -> bool | None:
    """Return the boolean of a *value* of a binary; None for any other value."""
    if same_scalar(value, feature.value_on):
        return True
    if same_scalar(value, feature.value_off):
        return False
    unreadable(value, (str(feature.value_on), str(feature.value_off)))
    return None


def read_finite(value: object) -> float | None:
    """Return the number *value*; None for any other value."""
    number = finite_number(value)
    if number is None:
        unreadable(value, "a number")
    return number


def same_scalar(value: object, expected: Scalar | None) -> bool:
    """Return whether *value* is *expected*; true and 1 differ."""
    return isinstance(value, bool) == isinstance(expected, bool) and value == expected


def text_of(value: object) -> str | None:
    """Return a short text, boolean or number as text; None for other values."""
    if isinstance(value, str):
        return clean_text(value, MAX_VALUE)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)) and finite_number(value) is not None:
        return str(value)
    return None


def _read(key: str, capability: str, read: Callable[[object], PlainValue], message: JsonMessage) -> Readings:
    if key not in message:
        return NO_READINGS
    value = message[key]
    if value is None or (CAPABILITIES[capability].kind == "number" and is_unknown(value)):
        return {capability: None}
    value_read = read(value)
    return NO_READINGS if value_read is None else {capability: value_read}


def _name_of(names: Mapping[str, str], value: object) -> str | None:
    return names.get(value) if isinstance(value, str) else None
