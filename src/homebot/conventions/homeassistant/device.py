"""Device of a config: its identifiers, name, area and facts, and its availability. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/schemas.py`` and ``entity.py``; ``child_device`` is from 2026.11.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple, TypeAlias, get_args

from homebot.conventions.description import Availability, AvailabilityMode
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.topics import StateMessage, ValueSource, state_topic
from homebot.conventions.jinja import Template
from homebot.conventions.payload import clean_text, shown
from homebot.devices.identity import identifiers
from homebot.errors import WireError

__all__ = ["MAX_IDENTIFIERS", "MAX_SOURCES", "DeviceInfo", "DeviceReader", "read_availability", "read_device"]


MAX_IDENTIFIERS = 64
"""Most identifiers and connections of one device."""


class DeviceInfo(NamedTuple):
    """The device block of a config.

    Attributes:
        identifiers: See :func:`homebot.devices.identity.identifiers`; empty for none.
        area: The announced room.
        facts: Such as ``manufacturer``, ``model``, ``sw_version``, ``via_device``, and ``origin``, the announcing
            program. Devices with equal facts share the mapping.
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
    told, by = _told(device, _DEVICE_FACTS), _told(origin, _ORIGIN_FACTS) if origin else ()
    if isinstance(child, dict):
        parent = _declared(device)
        via = (("via_device", parent[0]),) if parent else ()
        told = (*told, *_told(child, _DEVICE_FACTS), *via)
        device = {"suggested_area": device.get("suggested_area"), **child}
    declared = _declared(device)
    if device and not declared:
        raise WireError("a device has neither identifiers nor connections")
    return DeviceInfo(
        identifiers(declared),
        _as_text(device.get("name"), _MAX_NAME),
        _as_text(device["suggested_area"], _MAX_NAME) if "suggested_area" in device else "",
        _facts(told, by),
    )


class DeviceReader:
    """Reader of devices with the last one cached: the entities of one are announced in sequence."""

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
"""User and password in an address, which are removed."""

_PLAIN_CONNECTIONS = frozenset({"mac", "bluetooth", "zigbee"})
_PAIR = 2

_Told: TypeAlias = tuple[tuple[str, str], ...]
"""Fields with their texts, at most 255 long."""


def _told(fields: Mapping[str, object], names: Mapping[str, str]) -> _Told:
    """Return the facts among *fields*, in their order."""
    told: list[tuple[str, str]] = []
    for key, value in fields.items():
        if key in names:
            text = value if type(value) is str and len(value) <= _MAX_FACT else _as_text(value, _MAX_FACT)
            told.append((key, _LOGIN.sub("", text) if key in _ADDRESSES else text))
    return tuple(told)


@lru_cache(maxsize=256)
def _facts(device: _Told, origin: _Told) -> Mapping[str, str]:
    """Return the facts, shared by all devices of one model behind one bridge."""
    found: dict[str, str] = {}
    for told, names in ((device, _DEVICE_FACTS), (origin, _ORIGIN_FACTS)):
        for key, value in told:
            if text := _as_text(value, _MAX_FACT):
                found[names[key]] = text
    return MappingProxyType(found)


def _as_text(value: object, limit: int) -> str:
    if isinstance(value, str):
        # The result of clean_text for most texts, without the call.
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
"""Most topics of the availability of one device."""

_LONG = 1024
"""Characters of a topic beyond which an entry is not cached."""


class _Answers(NamedTuple):
    """The texts of reachable and unreachable devices of a bridge, and the template that extracts them."""

    template: Template | None
    encoding: str
    available: str
    unavailable: str

    def read(self, payload: bytes) -> bool | None:
        text = ValueSource("", self.template, self.encoding).text(StateMessage(payload))
        if text == self.available:
            return True
        return False if text == self.unavailable else None


class _PayloadAvailability(NamedTuple):
    """One topic with two payloads; see :class:`AvailabilitySource`."""

    topic: str
    answers: _Answers

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device is reachable; None for any other payload."""
        return self.answers.read(payload)


def read_availability(config: DiscoveryConfig) -> Availability | None:
    """Return the availability of the device; None if it reports none.

    Raises:
        WireError: Both forms exist, an entry has no valid topic, or the mode is invalid.
    """
    listed = config.values.get("availability")
    if listed is None:
        topic = config.state_topic("availability_topic") if config.values.get("availability_topic") is not None else ""
        return (
            Availability((_PayloadAvailability(topic, _answers(config, "availability_template")),)) if topic else None
        )
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
    topic = entry.get("topic")
    if topic and _ONLY_TEXTS.issuperset(map(type, entry.values())) and len(topic) <= _LONG:
        fields = tuple([field for field in entry.items() if field[0] != "topic"])
        return _PayloadAvailability(state_topic(topic), _known_answers(fields, config.encoding))
    own = _entry_config(entry, config.encoding)
    topic = own.state_topic("topic")
    if not topic:
        raise WireError("availability has an entry without topic")
    return _PayloadAvailability(topic, _answers(own, "value_template"))


def _entry_config(entry: Mapping[str, object], encoding: str) -> DiscoveryConfig:
    config = DiscoveryConfig("availability", "", {**entry, "encoding": encoding} if "encoding" in entry else entry)
    config.encoding = encoding
    return config


@lru_cache(maxsize=128)
def _known_answers(fields: tuple[tuple[str, str], ...], encoding: str) -> _Answers:
    """Return the answers of all devices with equal entries except for the topic."""
    return _answers(_entry_config(dict(fields), encoding), "value_template")


def _answers(config: DiscoveryConfig, template_key: str) -> _Answers:
    return _Answers(
        config.template(template_key),
        config.encoding,
        config.text("payload_available", "online"),
        config.text("payload_not_available", "offline"),
    )


_MODES: Mapping[str, AvailabilityMode] = {mode: mode for mode in get_args(AvailabilityMode)}


def _mode(text: str) -> AvailabilityMode:
    if text in _MODES:
        return _MODES[text]
    raise WireError(f"availability_mode is {shown(text)}, not all, any or latest")
