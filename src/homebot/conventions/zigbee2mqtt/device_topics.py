"""The topics of one Zigbee device, and how a message is written there. Pure.

Source: zigbee2mqtt.io, Usage > MQTT topics and messages; Zigbee2MQTT 2.14.1.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from homebot.conventions.command_values import require_transition
from homebot.conventions.description import Publication
from homebot.conventions.zigbee2mqtt.expose import SPECIFIC_TYPES, Expose
from homebot.errors import RefusedError

__all__ = ["Zigbee2MqttTopics", "whole_or_not"]

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
