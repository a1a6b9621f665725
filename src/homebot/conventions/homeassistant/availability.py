"""Availability of a device, as its config declares it. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/schemas.py`` and ``entity.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import get_args

from homebot.conventions.description import Availability, AvailabilityMode
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.incoming import StateMessage
from homebot.conventions.homeassistant.value_source import ValueSource
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["MAX_SOURCES", "PayloadAvailability", "read_availability"]

MAX_SOURCES = 16
"""Most topics that one device's availability may hang on."""


@dataclass(frozen=True, slots=True)
class PayloadAvailability:
    """One topic that says two words, and which they are; see :class:`AvailabilitySource`.

    Attributes:
        topic: The topic.
        source: Where it is found in the message.
        available: The word for yes.
        unavailable: The word for no.
    """

    topic: str
    source: ValueSource
    available: str
    unavailable: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device can be reached, or None when *payload* says neither."""
        text = self.source.text(StateMessage(payload))
        if text == self.available:
            return True
        return False if text == self.unavailable else None


def read_availability(config: DiscoveryConfig) -> Availability | None:
    """Return how the device tells whether it can be reached; None where it does not.

    Raises:
        WireError: Both forms are there, an entry has no valid topic, or the mode is none.
    """
    listed = config.values.get("availability")
    if listed is None:
        topic = config.state_topic("availability_topic")
        return Availability((_source(config, topic, "availability_template"),)) if topic else None
    if config.has("availability_topic"):
        raise WireError("availability and availability_topic exclude each other")
    entries = listed if isinstance(listed, list) else [listed]
    if len(entries) > MAX_SOURCES:
        raise WireError(f"availability has {len(entries)} topics; {MAX_SOURCES} is the limit")
    sources = tuple(_entry(config, entry) for entry in entries)
    return Availability(sources, _mode(config.text("availability_mode", "latest"))) if sources else None


def _entry(config: DiscoveryConfig, entry: object) -> PayloadAvailability:
    if not isinstance(entry, dict):
        raise WireError(f"availability has {shown(entry)}, not an object")
    if all(type(value) is str for value in entry.values()):
        return _known_entry(tuple(entry.items()), config.encoding)
    return _new_entry(entry, config.encoding)


def _new_entry(entry: Mapping[str, object], encoding: str) -> PayloadAvailability:
    config = DiscoveryConfig("availability", "", {**entry, "encoding": encoding} if "encoding" in entry else entry)
    config.encoding = encoding
    topic = config.state_topic("topic")
    if not topic:
        raise WireError("availability has an entry without topic")
    return _source(config, topic, "value_template")


@lru_cache(maxsize=128)
def _known_entry(fields: tuple[tuple[str, str], ...], encoding: str) -> PayloadAvailability:
    """All devices of a bridge share its entry, and all parts of a device share the device's."""
    return _new_entry(dict(fields), encoding)


def _source(config: DiscoveryConfig, topic: str, template_key: str) -> PayloadAvailability:
    return PayloadAvailability(
        topic,
        ValueSource(topic, config.template(template_key), config.encoding),
        config.text("payload_available", "online"),
        config.text("payload_not_available", "offline"),
    )


def _mode(text: str) -> AvailabilityMode:
    for mode in get_args(AvailabilityMode):
        if mode == text:
            known: AvailabilityMode = mode
            return known
    raise WireError(f"availability_mode is {shown(text)}, not all, any or latest")
