"""Device of a config: its identifiers, name, area and facts, and its availability. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/schemas.py`` and ``entity.py``; ``child_device`` is from 2026.11.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple, get_args

from homebot.conventions.description import Availability, AvailabilityMode
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.topics import StateMessage, ValueSource
from homebot.conventions.payload import clean_text, shown
from homebot.devices.identity import identifiers
from homebot.errors import WireError

__all__ = ["MAX_IDENTIFIERS", "MAX_SOURCES", "DeviceInfo", "DeviceReader", "read_availability", "read_device"]


MAX_IDENTIFIERS = 64
"""Most identifiers and connections of one device."""


class DeviceInfo(NamedTuple):
    """The device block of a config.

    Attributes:
        identifiers: See :func:`homebot.devices.identity.identifiers`; empty where the config names none.
        name: What people call it; empty where the config does not say.
        area: The room that was announced for it.
        facts: Such as ``manufacturer``, ``model``, ``sw_version``, ``via_device``; ``origin`` is who announced it.
    """

    identifiers: tuple[str, ...]
    name: str
    area: str
    facts: Mapping[str, str]


def read_device(device: Mapping[str, object], origin: Mapping[str, object]) -> DeviceInfo:
    """Return who the device is.

    Args:
        device: The config's ``device`` in full keys; empty where it has none.
        origin: The config's ``origin`` in full keys.

    Raises:
        WireError: The device is there but has neither identifier nor connection, or too many, or one is no text.
    """
    child = device.get("child_device")
    facts = _facts(device, _DEVICE_FACTS)
    if isinstance(child, dict):
        parent = _declared(device)
        device = {"suggested_area": device.get("suggested_area"), **child}
        facts = {**facts, **_facts(child, _DEVICE_FACTS), **({"via_device": parent[0]} if parent else {})}
    declared = _declared(device)
    if device and not declared:
        raise WireError("a device has neither identifiers nor connections")
    if origin:
        is_plain = len(origin) <= _FEW and _ONLY_TEXTS.issuperset(map(type, origin.values()))
        facts.update(_known_origin(tuple(origin.items())) if is_plain else _facts(origin, _ORIGIN_FACTS))
    return DeviceInfo(
        identifiers(declared),
        _as_text(device.get("name"), _MAX_NAME),
        _as_text(device["suggested_area"], _MAX_NAME) if "suggested_area" in device else "",
        facts,
    )


class DeviceReader:
    """Reads devices and remembers the last: the entities of one are announced one after the other."""

    def __init__(self) -> None:
        self._last: tuple[Mapping[str, object], Mapping[str, object], DeviceInfo] | None = None

    def read(self, device: Mapping[str, object], origin: Mapping[str, object]) -> DeviceInfo:
        """Read as :func:`read_device` does."""
        last = self._last
        if last is not None and last[0] == device and last[1] == origin:
            return last[2]
        info = read_device(device, origin)
        self._last = device, origin, info
        return info


_MAX_NAME = 120
_MAX_FACT = 255
_MAX_ID = 255
_ONLY_TEXTS = frozenset({str})
_DEVICE_FACTS = {
    name: name
    for name in (
        "manufacturer",
        "model",
        "model_id",
        "serial_number",
        "hw_version",
        "sw_version",
        "via_device",
        "configuration_url",
    )
}
_ORIGIN_FACTS = {"name": "origin", "sw_version": "origin_sw_version", "support_url": "origin_url"}
_ADDRESSES = frozenset({"configuration_url", "support_url"})
_LOGIN = re.compile(r"(?<=://)[^/?#]*@")
"""User and password in an address, which are nobody's to read."""

_PLAIN_CONNECTIONS = frozenset({"mac", "bluetooth", "zigbee"})
_PAIR = 2
_FEW = 8
"""Fields of an origin that is remembered; it has three."""


def _facts(fields: Mapping[str, object], names: Mapping[str, str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for key, value in fields.items():
        if key in names and (text := _as_text(value, _MAX_FACT)):
            found[names[key]] = _LOGIN.sub("", text) if key in _ADDRESSES else text
    return found


@lru_cache(maxsize=64)
def _known_origin(fields: tuple[tuple[str, str], ...]) -> Mapping[str, str]:
    """Return the facts of one who announces, as all devices of a bridge have them; not to be changed."""
    return _facts(dict(fields), _ORIGIN_FACTS)


def _as_text(value: object, limit: int) -> str:
    if isinstance(value, str):
        # As clean_text says it, for most texts of an announcement without that call.
        return value.strip() if len(value) <= limit and value.isprintable() else clean_text(value, limit)
    if isinstance(value, (bool, float)) or (isinstance(value, int) and abs(value) < _HUGE):
        return str(value)
    return ""


_HUGE = 10**30


def _declared(device: Mapping[str, object]) -> list[str]:
    listed = device.get("identifiers")
    ids = listed if isinstance(listed, list) else [] if listed is None else [listed]
    connections = device.get("connections")
    pairs = connections if isinstance(connections, list) else [] if connections is None else [connections]
    if len(ids) + len(pairs) > MAX_IDENTIFIERS:
        raise WireError(f"a device has {len(ids) + len(pairs)} identifiers; {MAX_IDENTIFIERS} is the limit")
    found = list(map(_identifier, ids))
    if pairs:
        found += map(_connection, pairs)
    return found


def _identifier(value: object) -> str:
    text = _as_text(value, _MAX_ID)
    if not text:
        raise WireError(f"an identifier of a device is {shown(value)}, not a text")
    return text


def _connection(pair: object) -> str:
    if not isinstance(pair, list) or len(pair) != _PAIR:
        raise WireError(f"a connection of a device is {shown(pair)}, not a type and a value")
    kind, value = (_identifier(one) for one in pair)
    return value if kind.lower() in _PLAIN_CONNECTIONS else f"{kind}:{value}"


MAX_SOURCES = 16
"""Most topics that one device's availability may hang on."""


class _PayloadAvailability(NamedTuple):
    """One topic with two payloads; see :class:`AvailabilitySource`.

    Attributes:
        topic: The topic.
        source: Where it is found in the message.
        available: The text of a device that can be reached.
        unavailable: The text of one that cannot.
    """

    topic: str
    source: ValueSource
    available: str
    unavailable: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device can be reached, or None when *payload* means neither."""
        text = self.source.text(StateMessage(payload))
        if text == self.available:
            return True
        return False if text == self.unavailable else None


def read_availability(config: DiscoveryConfig) -> Availability | None:
    """Return how the device reports whether it can be reached; None where it does not.

    Raises:
        WireError: Both forms are there, an entry has no valid topic, or the mode is none.
    """
    listed = config.values.get("availability")
    if listed is None:
        topic = config.state_topic("availability_topic") if config.values.get("availability_topic") is not None else ""
        return Availability((_source(config, topic, "availability_template"),)) if topic else None
    if config.has("availability_topic"):
        raise WireError("availability and availability_topic exclude each other")
    entries = listed if isinstance(listed, list) else [listed]
    if len(entries) > MAX_SOURCES:
        raise WireError(f"availability has {len(entries)} topics; {MAX_SOURCES} is the limit")
    sources = tuple([_entry(config, entry) for entry in entries])
    return Availability(sources, _mode(config.text("availability_mode", "latest"))) if sources else None


def _entry(config: DiscoveryConfig, entry: object) -> _PayloadAvailability:
    if not isinstance(entry, dict):
        raise WireError(f"availability has {shown(entry)}, not an object")
    if _ONLY_TEXTS.issuperset(map(type, entry.values())):
        return _known_entry(tuple(entry.items()), config.encoding)
    return _new_entry(entry, config.encoding)


def _new_entry(entry: Mapping[str, object], encoding: str) -> _PayloadAvailability:
    config = DiscoveryConfig("availability", "", {**entry, "encoding": encoding} if "encoding" in entry else entry)
    config.encoding = encoding
    topic = config.state_topic("topic")
    if not topic:
        raise WireError("availability has an entry without topic")
    return _source(config, topic, "value_template")


@lru_cache(maxsize=128)
def _known_entry(fields: tuple[tuple[str, str], ...], encoding: str) -> _PayloadAvailability:
    """Return the entry that all devices of a bridge share, as all parts of a device share the device's."""
    return _new_entry(dict(fields), encoding)


def _source(config: DiscoveryConfig, topic: str, template_key: str) -> _PayloadAvailability:
    return _PayloadAvailability(
        topic,
        ValueSource(topic, config.template(template_key), config.encoding),
        config.text("payload_available", "online"),
        config.text("payload_not_available", "offline"),
    )


_MODES: Mapping[str, AvailabilityMode] = {mode: mode for mode in get_args(AvailabilityMode)}


def _mode(text: str) -> AvailabilityMode:
    if text in _MODES:
        return _MODES[text]
    raise WireError(f"availability_mode is {shown(text)}, not all, any or latest")
