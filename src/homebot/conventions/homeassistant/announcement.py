"""A config message in full keys, before the fields of its components are read. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/discovery.py``; ``child_devices`` and the shared ``encoding``,
``qos`` and ``message_expiry_interval`` are from 2026.11.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple, TypeAlias

from homebot.conventions.homeassistant.abbreviations import ABBREVIATIONS, DEVICE_ABBREVIATIONS, ORIGIN_ABBREVIATIONS
from homebot.conventions.homeassistant.components import BUILDERS
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.topics import DEVICE, ConfigTopic
from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, parse_object, shown
from homebot.errors import WireError

__all__ = ["MAX_COMPONENTS", "Announced", "read_announcement"]

MAX_COMPONENTS = 300
"""Most components of one device: each may bring templates, which cost a millisecond at worst."""

Fields: TypeAlias = Mapping[str, object]


class Announced(NamedTuple):
    """The content of one announcement.

    Attributes:
        device: The device in full keys; empty for none.
        origin: The announcing program, in full keys.
        components: The components of the device, without removed ones and unknown ones. The id of one without a
            ``unique_id`` is the key of the announcement and, for a whole device, its name in the message.
        common: The shared fields, or those of a single component; they have the availability of the device.
    """

    device: Fields
    origin: Fields
    components: tuple[DiscoveryConfig, ...]
    common: Fields


def read_announcement(topic: ConfigTopic, payload: bytes) -> Announced | None:
    """Return the content of a config that is not empty; None if another form of announcement follows.

    Raises:
        WireError: It is not a JSON object, too long, or lacks a required field.
    """
    fields = parse_object(payload, MAX_ANNOUNCEMENT_BYTES)
    if fields.get("migrate_discovery", fields.get("migr_discvry")) is True:
        return None
    fields = _expanded(fields)
    device = _part(fields, "device", DEVICE_ABBREVIATIONS) if "device" in fields else {}
    origin = _part(fields, "origin", ORIGIN_ABBREVIATIONS) if "origin" in fields else {}
    if topic.component == DEVICE:
        components = tuple(_components(topic, fields))
    else:
        if _BASE in fields:
            fields = _with_base(fields)
        components = (DiscoveryConfig(topic.component, topic.key, fields),)
    return Announced(device, origin, components, common=fields)


_BASE = "~"
_SHARED = (
    "availability",
    "availability_mode",
    "availability_template",
    "availability_topic",
    "command_topic",
    "payload_available",
    "payload_not_available",
    "state_topic",
    "encoding",
    "qos",
    "message_expiry_interval",
)


def _expanded(fields: dict[str, object]) -> dict[str, object]:
    """Expand the keys, also those of the availability."""
    full = fields if ABBREVIATIONS.keys().isdisjoint(fields) else _full_keys(fields, ABBREVIATIONS)
    availability = full.get("availability")
    if isinstance(availability, dict):
        full["availability"] = _full_keys(availability, ABBREVIATIONS)
    elif isinstance(availability, list):
        full["availability"] = [
            one if not isinstance(one, dict) or ABBREVIATIONS.keys().isdisjoint(one) else _full_keys(one, ABBREVIATIONS)
            for one in availability
        ]
    return full


def _full_keys(fields: Fields, table: Mapping[str, str]) -> dict[str, object]:
    """Expand the keys; of both forms of a key the short one wins."""
    full = dict(fields)
    for key in fields:
        if key in table:
            full[table[key]] = full.pop(key)
    return full


def _part(fields: Fields, key: str, table: Mapping[str, str]) -> Fields:
    part = fields[key]
    if part is None:
        return {}
    if not isinstance(part, dict):
        raise WireError(f"{key} is {shown(part)}, not an object")
    return part if table.keys().isdisjoint(part) else _full_keys(part, table)


def _with_base(fields: dict[str, object]) -> dict[str, object]:
    base = fields.pop(_BASE, None)
    if base is None:
        return fields
    if not isinstance(base, str):
        raise WireError(f"~ is {shown(base)}, not a topic")
    based = {key: _based(base, value) if key.endswith("topic") else value for key, value in fields.items()}
    availability = based.get("availability")
    if isinstance(availability, list):
        based["availability"] = [_based_entry(base, one) for one in availability]
    elif availability is not None:
        based["availability"] = _based_entry(base, availability)
    return based


def _based_entry(base: str, entry: object) -> object:
    if isinstance(entry, dict) and "topic" in entry:
        return {**entry, "topic": _based(base, entry["topic"])}
    return entry


def _based(base: str, topic: object) -> object:
    if not isinstance(topic, str) or not topic:
        return topic
    if topic[0] == _BASE:
        topic = base + topic[1:]
    if topic.endswith(_BASE):
        topic = topic[:-1] + base
    return topic


def _child_devices(fields: Fields) -> Iterator[Fields]:
    children = fields.get("child_devices")
    for child in children if isinstance(children, list) else ():
        if isinstance(child, dict):
            yield _full_keys(child, ABBREVIATIONS)


def _components(topic: ConfigTopic, fields: Fields) -> list[DiscoveryConfig]:
    families = [one["components"] for one in (fields, *_child_devices(fields)) if one.get("components") is not None]
    if not families:
        raise WireError("a device's message has no components")
    common = {key: fields[key] for key in _SHARED if key in fields}
    found: list[DiscoveryConfig] = []
    for family in families:
        if not isinstance(family, dict):
            raise WireError(f"components is {shown(family)}, not an object")
        if len(found) + len(family) > MAX_COMPONENTS:
            raise WireError(f"a device has more than {MAX_COMPONENTS} components")
        components = (_component(topic, name, entry, common) for name, entry in family.items())
        found += [component for component in components if component is not None]
    return found


def _component(topic: ConfigTopic, name: str, entry: object, common: Fields) -> DiscoveryConfig | None:
    """Return one component; None for a removed or an unknown one."""
    if not isinstance(entry, dict):
        raise WireError(f"component {shown(name)} is {shown(entry)}, not an object")
    full = _expanded(entry)
    platform = full.pop("platform", None)
    if not isinstance(platform, str):
        raise WireError(f"component {shown(name)}: platform is {shown(platform)}, not a text")
    if not full or platform not in BUILDERS:
        return None
    return DiscoveryConfig(platform, f"{topic.key}/{name}", _with_base({**common, **full}))
