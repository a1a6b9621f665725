"""Device of a config: its identifiers, name, area and facts, and its availability. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/schemas.py`` and ``entity.py``; ``child_device`` is from 2026.11.
"""

import re
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType, NoneType
from typing import NamedTuple, get_args

from pydantic_core import to_json

from homebot.conventions.description import Availability, AvailabilityMode
from homebot.conventions.payload import clean_text, shown
from homebot.devices.identity import identifiers, in_pairs
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.abbreviations import (
    ABBREVIATIONS,
    DEVICE_ABBREVIATIONS,
    ORIGIN_ABBREVIATIONS,
)
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig, full_keys
from homebot.integrations.homeassistant.formats.topics import ValueSource
from homebot.support.bounded_map import BoundedMap

MAX_IDENTIFIERS = 64
"""Most identifiers and connections of one device."""


class DeviceInfo(NamedTuple):
    """The device block of a config.

    Attributes:
        identifiers: See :func:`homebot.devices.identity.identifiers`; empty for none.
        area: The announced room.
        facts: Such as ``manufacturer``, ``model``, ``sw_version``, ``via_device``, and ``origin``, the announcing
            program.
    """

    identifiers: tuple[str, ...]
    name: str
    area: str
    facts: Mapping[str, str]


def read_device(device: Mapping[str, object], origin: Mapping[str, object]) -> DeviceInfo:
    """Return the device of a config, from its ``device`` and its ``origin`` in full keys.

    Raises:
        WireError: The device has neither identifier nor connection, or too many, or one is no text.
    """
    child = device.get("child_device")
    facts = _facts(device, _DEVICE_FACTS)
    if isinstance(child, dict):
        parent = _declared(device)
        facts |= _facts(child, _DEVICE_FACTS) | ({"via_device": parent[0]} if parent else {})
        device = {"suggested_area": device.get("suggested_area"), **child}
    declared = _declared(device)
    if device and not declared:
        raise WireError("a device has neither identifiers nor connections")
    if origin:
        facts |= _facts(origin, _ORIGIN_FACTS)
    return DeviceInfo(
        identifiers(declared),
        _as_text(device.get("name"), _MAX_NAME),
        _as_text(device["suggested_area"], _MAX_NAME) if "suggested_area" in device else "",
        _shared(tuple(facts.items())),
    )


_MAX_CACHED = 5000
"""Devices, and availabilities: all configs of a device have them, but not one after the other."""

_DEVICES: BoundedMap[bytes, DeviceInfo] = BoundedMap(_MAX_CACHED)
_AVAILABILITIES: BoundedMap[bytes, Availability] = BoundedMap(_MAX_CACHED)


def cached_device(device: object, origin: object) -> DeviceInfo:
    """Return :func:`read_device` of a device and an origin as announced: None for none, also in short keys.

    Raises:
        WireError: As there, or one is no object.
    """
    text = to_json((device, origin))
    if (known := _DEVICES.get(text)) is not None:
        return known
    for name, fields in (("device", device), ("origin", origin)):
        if not isinstance(fields, (dict, NoneType)):
            raise WireError(f"{name} is {shown(fields)}, not an object")
    about = _DEVICES[text] = read_device(
        full_keys(device, DEVICE_ABBREVIATIONS) if isinstance(device, dict) else {},
        full_keys(origin, ORIGIN_ABBREVIATIONS) if isinstance(origin, dict) else {},
    )
    return about


def cached_availability(config: DiscoveryConfig) -> Availability | None:
    """Return :func:`read_availability`, one object for all equal ones."""
    if _SOURCES.isdisjoint(config.values):
        return None
    text = to_json((config.encoding, *map(config.values.get, _AVAILABILITY)))
    if (known := _AVAILABILITIES.get(text)) is not None:
        return known
    availability = read_availability(config)
    if availability is not None:
        _AVAILABILITIES[text] = availability
    return availability


_AVAILABILITY = (
    *("availability", "availability_mode", "availability_template", "availability_topic"),
    *("payload_available", "payload_not_available"),
)
_SOURCES = frozenset({"availability", "availability_topic"})
"""Fields without which a config has no availability, whatever its other fields are."""


@lru_cache(maxsize=256)
def _shared(facts: tuple[tuple[str, str], ...]) -> Mapping[str, str]:
    """Return the facts, one mapping for all devices of a model."""
    return MappingProxyType(dict(facts))


_MAX_NAME = 120
_MAX_FACT = 255
_MAX_ID = 255
_DEVICE_FIELDS = (
    *("manufacturer", "model", "model_id", "serial_number", "hw_version", "sw_version", "via_device"),
    "configuration_url",
)
_DEVICE_FACTS = {name: name for name in _DEVICE_FIELDS}
_ORIGIN_FACTS = {"name": "origin", "sw_version": "origin_sw_version", "support_url": "origin_url"}
_LOGIN = re.compile(r"(?<=://)[^/?#]*@")
"""User and password in an address, which are removed."""

_PLAIN_CONNECTIONS = frozenset({"mac", "bluetooth", "zigbee"})
_PAIR = 2
_HUGE = 10**30


def _facts(fields: Mapping[str, object], names: Mapping[str, str]) -> dict[str, str]:
    """Return the facts among *fields*, in their order."""
    facts = {}
    for key, value in fields.items():
        if key in names and (text := _as_text(value, _MAX_FACT)):
            facts[names[key]] = _LOGIN.sub("", text) if key.endswith("url") else text
    return facts


def _as_text(value: object, limit: int) -> str:
    if isinstance(value, str):
        return clean_text(value, limit)
    if isinstance(value, (bool, float)) or (isinstance(value, int) and abs(value) < _HUGE):
        return str(value)
    return ""


def _declared(device: Mapping[str, object]) -> list[str]:
    declared = [_identifier(identifier) for identifier in _as_list(device.get("identifiers")) if identifier != ""]
    if "connections" in device:
        pairs = _as_list(device["connections"])
        declared += [_connection(pair) for pair in pairs if not (isinstance(pair, list) and pair[1:] == [""])]
    if len(declared) > MAX_IDENTIFIERS:
        raise WireError(f"a device has {len(declared)} identifiers; {MAX_IDENTIFIERS} is the limit")
    return declared


def _as_list(value: object) -> list[object]:
    return value if isinstance(value, list) else [] if value is None else [value]


def _identifier(value: object) -> str:
    text = _as_text(value, _MAX_ID)
    if not text:
        raise WireError(f"an identifier of a device is {shown(value)}, not a text")
    return text


def _connection(pair: object) -> str:
    if not isinstance(pair, list) or len(pair) != _PAIR:
        raise WireError(f"a connection of a device is {shown(pair)}, not a type and a value")
    kind, value = (_identifier(item) for item in pair)
    return in_pairs(value) if kind.lower() in _PLAIN_CONNECTIONS else f"{kind}:{value}"


MAX_SOURCES = 16
"""Most topics of the availability of one device."""


class _PayloadAvailability(NamedTuple):
    """One topic with two payloads; see :class:`AvailabilitySource`."""

    topic: str
    source: ValueSource
    available: str
    unavailable: str

    def read(self, payload: bytes) -> bool | None:
        text = self.source.text(payload)
        return True if text == self.available else False if text == self.unavailable else None


def read_availability(config: DiscoveryConfig) -> Availability | None:
    """Return the availability of the device; None if it reports none.

    Raises:
        WireError: Both forms exist, an entry has no valid topic, or the mode is invalid.
    """
    listed = config.values.get("availability")
    if listed is None:
        own = _source(config, "availability_topic", "availability_template")
        return Availability((own,)) if own else None
    if config.has("availability_topic"):
        raise WireError("availability and availability_topic exclude each other")
    entries = _as_list(listed)
    if len(entries) > MAX_SOURCES:
        raise WireError(f"availability has {len(entries)} topics; {MAX_SOURCES} is the limit")
    sources = tuple([_entry(config, entry) for entry in entries])
    if not sources:
        return None
    mode = config.text("availability_mode", "latest")
    if mode not in _MODES:
        raise WireError(f"availability_mode is {shown(mode)}, not all, any or latest")
    return Availability(sources, _MODES[mode])


def _entry(config: DiscoveryConfig, entry: object) -> _PayloadAvailability:
    if not isinstance(entry, dict):
        raise WireError(f"availability has {shown(entry)}, not an object")
    own = DiscoveryConfig("availability", "", full_keys(entry, ABBREVIATIONS))
    own.encoding = config.encoding
    source = _source(own, "topic", "value_template")
    if source is None:
        raise WireError("availability has an entry without topic")
    return source


def _source(config: DiscoveryConfig, topic_key: str, template_key: str) -> _PayloadAvailability | None:
    source = config.source(topic_key, template_key)
    if source is None:
        return None
    available = config.text("payload_available", "online")
    return _PayloadAvailability(source.topic, source, available, config.text("payload_not_available", "offline"))


_MODES: Mapping[str, AvailabilityMode] = {mode: mode for mode in get_args(AvailabilityMode)}
