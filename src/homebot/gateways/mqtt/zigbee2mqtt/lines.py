"""The topics of one Zigbee device, and how a message is written there. Pure.

Source: zigbee2mqtt.io, Usage > MQTT topics and messages; Zigbee2MQTT 2.14.1.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from homebot.errors import RefusedError
from homebot.gateways.mqtt.description import Publication
from homebot.gateways.mqtt.wanted import wanted_transition
from homebot.gateways.mqtt.zigbee2mqtt.expose import Expose

__all__ = ["Lines", "whole_or_not"]

_MOST_SECONDS = 6_553.0
"""Longest transition that fits into a Zigbee frame: 65,535 tenths of a second, less those that mean "as you like"."""


@dataclass(frozen=True, slots=True)
class Lines:
    """Where one device speaks and listens.

    Attributes:
        said: Topic of its state, a JSON object of all that it tells.
        is_awake: Whether it can be asked: one with a battery sleeps and never answers.
    """

    said: str
    is_awake: bool = True

    @property
    def told(self) -> str:
        """The topic that it listens on."""
        return f"{self.said}/set"

    def tell(self, message: Mapping[str, object], transition: float = 0.0) -> tuple[Publication, ...]:
        """Return what to publish to set each property of *message*.

        Args:
            message: Values by property.
            transition: Seconds that the change shall take; 0 leaves it to the device.

        Raises:
            RefusedError: *transition* is out of bounds, or a text cannot be written in UTF-8.
        """
        seconds = wanted_transition(transition, _MOST_SECONDS)
        fields = {**message, "transition": whole_or_not(seconds)} if seconds else message
        try:
            payload = json.dumps(fields, ensure_ascii=False, separators=(",", ":")).encode()
        except UnicodeEncodeError:
            raise RefusedError(f"a command to {self.said}", "it cannot be written in UTF-8") from None
        return (Publication(self.told, payload),)

    def ask(self, *features: Expose | None) -> tuple[Publication, ...]:
        """Return what to publish so that the device tells *features*; nothing for those that cannot be asked for."""
        wanted = _gettable(features) if self.is_awake else {}
        if not wanted:
            return ()
        payload = json.dumps(wanted, ensure_ascii=False, separators=(",", ":")).encode()
        return (Publication(f"{self.said}/get", payload),)


def whole_or_not(number: float) -> float | int:
    """Return *number* as people write it: 21 rather than 21.0."""
    return int(number) if number.is_integer() else number


def _gettable(features: Iterable[Expose | None]) -> dict[str, str]:
    return {one.key: "" for one in features if one is not None and one.is_gettable}
