"""A config message in full keys, before the fields of its components are read. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/discovery.py``; ``child_devices`` and the shared ``encoding``,
``qos`` and ``message_expiry_interval`` are from 2026.11.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple, TypeAlias

from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, parse_object, shown, text_of
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.abbreviations import ABBREVIATIONS, full_keys
from homebot.integrations.homeassistant.formats.components import BUILDERS
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.topics import DEVICE, ConfigTopic

MAX_COMPONENTS = 300
"""Most components of one device: each may bring templates, which cost a millisecond at worst."""

Fields: TypeAlias = Mapping[str, object]


class Announced(NamedTuple):
    """The content of one announcement.

    Attributes:
        components: The components of the device, without removed ones and unknown ones. The id of one without a
            ``unique_id`` is the key of the announcement and, for a whole device, its name in the message.
        common: The shared fields, or those of a single component; they have the device and its availability.
        problems: Why components of a whole device are left out.
    """

    components: tuple[DiscoveryConfig, ...]
    common: Fields
    problems: tuple[WireError, ...] = ()


def read_announcement(topic: ConfigTopic, payload: bytes) -> Announced | None:
    """Return the content of a config that is not empty; None if another form of announcement follows.

    Raises:
        WireError: It is not a JSON object, too long, or lacks a required field.
    """
    fields = parse_object(payload, MAX_ANNOUNCEMENT_BYTES)
    if fields.get("migrate_discovery", fields.get("migr_discvry")) is True:
        return None
    fields = full_keys(fields, ABBREVIATIONS)
    if topic.component == DEVICE:
        return _whole_device(topic, fields)
    if _BASE in fields:
        fields = _with_base(fields)
    return Announced((DiscoveryConfig(topic.component, topic.key, fields),), common=fields)


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


def _with_base(fields: dict[str, object]) -> dict[str, object]:
    base = fields.pop(_BASE, None)
    if base is None:
        return fields
    if not isinstance(base, str):
        raise WireError(f"~ is {shown(base)}, not a topic")
    based = {key: _based(base, value) if key.endswith("topic") else value for key, value in fields.items()}
    availability = based.get("availability")
    if isinstance(availability, list):
        based["availability"] = [_based_entry(base, entry) for entry in availability]
    elif availability is not None:
        based["availability"] = _based_entry(base, availability)
    return based


def _based_entry(base: str, entry: object) -> object:
    if not isinstance(entry, dict):
        return entry
    return {
        key: _based(base, value) if key == "topic" else value for key, value in full_keys(entry, ABBREVIATIONS).items()
    }


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
            yield full_keys(child, ABBREVIATIONS)


def _whole_device(topic: ConfigTopic, fields: Fields) -> Announced:
    families = [family for family in (fields, *_child_devices(fields)) if family.get("components") is not None]
    if not families:
        raise WireError("a device's message has no components")
    common = {key: fields[key] for key in _SHARED if key in fields}
    configs: list[DiscoveryConfig] = []
    problems: list[WireError] = []
    entries: list[tuple[str, object, Fields]] = []
    for family in families:
        components = family["components"]
        if not isinstance(components, dict):
            raise WireError(f"components is {shown(components)}, not an object")
        entries += ((name, entry, family) for name, entry in components.items())
    if len(entries) > MAX_COMPONENTS:
        raise WireError(f"a device has more than {MAX_COMPONENTS} components")
    for name, entry, child in entries:
        try:
            component = _component(topic, name, entry, common, "" if child is fields else text_of(child.get("name")))
        except WireError as error:
            problems.append(WireError(f"component {shown(name)}: {error}"))
        else:
            configs += () if component is None else (component,)
    if problems and not configs:
        raise problems[0]
    return Announced(tuple(configs), fields, tuple(problems))


def _component(topic: ConfigTopic, name: str, entry: object, common: Fields, child: str) -> DiscoveryConfig | None:
    """Return one component, with the name of its *child* device before its own; None if removed or unknown."""
    if not isinstance(entry, dict):
        raise WireError(f"it is {shown(entry)}, not an object")
    full = full_keys(entry, ABBREVIATIONS)
    platform = full.pop("platform", None)
    if not isinstance(platform, str):
        raise WireError(f"platform is {shown(platform)}, not a text")
    if not full or platform not in BUILDERS:
        return None
    if child:
        full["name"] = f"{child} {text_of(full.get('name'))}".strip()
    return DiscoveryConfig(platform, f"{topic.key}/{name}", _with_base({**common, **full}))
