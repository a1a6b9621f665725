"""Reader of Home Assistant's discovery configs: configs in, descriptions out. Pure.

A large house has five times as many configs as shapes of them: one shape for the batteries of all devices, and so on.
One part of a shape is built; the others are made after it.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``, of these ``discovery.py``; ``child_devices`` and the
shared ``encoding``, ``qos`` and ``message_expiry_interval`` are from 2026.11.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from importlib import import_module
from operator import attrgetter
from typing import NamedTuple, TypeAlias, cast

from pydantic_core import to_json

from homebot.conventions.description import (
    TRACKER_SILENCE,
    AnnouncementEvent,
    Availability,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
)
from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, clean_text, parse_object, shown, text_of
from homebot.conventions.table_codec import is_movable, moved
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.abbreviations import ABBREVIATIONS
from homebot.integrations.homeassistant.formats.components import BUILDERS
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig, full_keys
from homebot.integrations.homeassistant.formats.device import cached_availability, cached_device, read_availability
from homebot.support.bounded_map import BoundedMap

DEVICE = "device"
"""The component of a config of a whole device."""

_LEVELS = (2, 3)
_MAX_CONFIG_TOPIC = 512


class ConfigTopic(NamedTuple):
    """The component of a config's topic, or :data:`DEVICE`, its object id, and the key of the announcement.

    The key has all levels between prefix and ``config``.
    """

    component: str
    object_id: str
    key: str


def parse_config_topic(prefix: str, topic: str) -> ConfigTopic | None:
    """Return the levels of *topic*; None if it is no config below *prefix*.

    Home Assistant accepts ids of letters, digits, ``_`` and ``-``. Real devices have others too, such as the button
    ``recall_*`` of a remote; they are accepted here.

    Raises:
        WireError: It is a config, but longer than 512 characters.
    """
    if not topic.startswith(f"{prefix}/") or not topic.endswith("/config"):
        return None
    key = topic[len(prefix) + 1 : -len("/config")]
    levels = key.split("/")
    if len(levels) not in _LEVELS:
        return None
    if len(topic) > _MAX_CONFIG_TOPIC:
        raise WireError(f"topic {shown(topic)} is {len(topic)} long; {_MAX_CONFIG_TOPIC} is the limit for a config")
    return ConfigTopic(levels[0], levels[-1], key if levels[1] else f"{levels[0]}/{levels[-1]}")


SHAPED = frozenset({"binary_sensor", "button", "light", "number", "select", "sensor", "switch", "text"})
"""Components that many devices have alike."""

_OWN = frozenset(
    {
        *("availability", "availability_mode", "availability_template", "payload_available", "payload_not_available"),
        *("default_entity_id", "device", "name", "object_id", "origin", "unique_id"),
    }
)
"""Fields that are no part of a shape: the identity, and the availability, which is read apart from the part."""

_PLAIN_TOPIC = re.compile("[^+#$\x00-\x1f\x7f-\x9f\ufdd0-\ufdef\ufffe\uffff]{1,255}").fullmatch
_MAX_SHAPES = 1000
_MAX_SHAPE_CHARACTERS = 2048


class _Shape(NamedTuple):
    """The part of a config that equal parts share.

    Attributes:
        topics: The fields with topics.
        places: Of each topic, the place of the first that is the same.
        others: All other fields, in JSON.
    """

    component: str
    is_secret: bool
    topics: tuple[str, ...]
    places: tuple[int, ...]
    others: bytes


class PartShapes:
    """The last thousand shapes of parts, each with the first part and its topics."""

    def __init__(self) -> None:
        self._known: BoundedMap[_Shape, tuple[DescribedPart, list[str]]] = BoundedMap(_MAX_SHAPES)

    def part(self, config: DiscoveryConfig, build: Callable[[DiscoveryConfig], DescribedPart]) -> DescribedPart:
        """Return the part that *build* makes of *config*.

        Raises:
            WireError: The config is invalid.
        """
        topics: list[str] = []
        shape = _shape_of(config, topics)
        if shape is None:
            return build(config)
        known = self._known.get(shape)
        if known is not None:
            first, its_topics = known
            own = dict(zip(its_topics, topics, strict=True))
            name = config.clean_text("name") if config.values.get("name") else ""
            return moved(first, own, part_id=config.part_id, name=name)
        described = build(config)
        if is_movable(described, topics):
            self._known[shape] = described, topics
        return described


def _shape_of(config: DiscoveryConfig, topics: list[str]) -> _Shape | None:
    """Return the shape of *config*, its topics added to *topics*; None for an unusual one."""
    values = config.values
    if config.component not in SHAPED or not isinstance(values.get("name", ""), (str, type(None))):
        return None
    names, places, others = [], [], {}
    for key, value in values.items():
        if key.endswith("topic"):
            if not isinstance(value, str) or not _PLAIN_TOPIC(value):
                return None
            names.append(key)
            topics.append(value)
            places.append(topics.index(value))
        elif key not in _OWN:
            others[key] = value
    text = to_json(others)
    if len(text) > _MAX_SHAPE_CHARACTERS:
        return None
    return _Shape(config.component, config.is_secret, tuple(names), tuple(places), text)


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
    based = {key: _expand(base, value) if key.endswith("topic") else value for key, value in fields.items()}
    availability = based.get("availability")
    if isinstance(availability, list):
        based["availability"] = [_expand_base_of_entry(base, entry) for entry in availability]
    elif availability is not None:
        based["availability"] = _expand_base_of_entry(base, availability)
    return based


def _expand_base_of_entry(base: str, entry: object) -> object:
    if not isinstance(entry, dict):
        return entry
    return {
        key: _expand(base, value) if key == "topic" else value for key, value in full_keys(entry, ABBREVIATIONS).items()
    }


def _expand(base: str, topic: object) -> object:
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


class HomeAssistantReader:
    """Reader of configs; counts the invalid components of a device with valid ones."""

    def __init__(self, prefixes: tuple[str, ...], *, is_fahrenheit: bool = False) -> None:
        self.rejected = 0
        self._is_fahrenheit = is_fahrenheit
        self._prefixes = prefixes
        self._shapes = PartShapes()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - configs are retained
        """Return the description in a config."""
        config_topic = None
        for prefix in self._prefixes:
            if (config_topic := parse_config_topic(prefix, topic)) is not None:
                break
        if config_topic is None or (config_topic.component != DEVICE and config_topic.component not in BUILDERS):
            return ()
        if not payload:
            return (DeviceWithdrawn(config_topic.key, "its config was removed"),)
        announced = read_announcement(config_topic, payload)
        if announced is None:
            return (DeviceWithdrawn(config_topic.key, "it is moving to another kind of discovery message"),)
        problems = [*announced.problems]
        parts = self._parts(config_topic, announced, problems)
        if not parts:
            return (DeviceWithdrawn(config_topic.key, "it has no components left"),)
        return (_describe(topic, config_topic, announced, parts), *problems)

    def _parts(self, config_topic: ConfigTopic, announced: Announced, problems: list[WireError]) -> _Parts:
        """Build the parts, without codes and passwords, and without a whole device's components with *problems*."""
        parts: _Parts = {}
        for config in announced.components:
            try:
                if self._is_fahrenheit and config.component in _HEATING and not config.has("temperature_unit"):
                    config.values = {**config.values, "temperature_unit": "F"}
                build = builder_of(config.component)
                part = self._shapes.part(config, build) if config.component in SHAPED else build(config)
                if "group" in config.values:
                    part = _with_members(part, config)
                if config_topic.component == DEVICE:
                    part = part._replace(availability=cached_availability(config))
            except WireError as error:
                if config_topic.component != DEVICE:
                    raise
                problems.append(WireError(f"{config.discovery_id}: {error}"))
                continue
            if not part.part.capabilities and config.is_secret:
                continue
            if part.part.id in parts:
                part = part._replace(part=part.part.model_copy(update={"id": config.discovery_id}))
            parts[part.part.id] = part, config
        self.rejected += len(problems)
        if problems and not parts:
            self.rejected -= 1
            raise problems[0]
        return parts


_Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]
"""Builds the part of a component's config; raises WireError if Home Assistant would refuse the config."""


@lru_cache(maxsize=len(BUILDERS))
def builder_of(component: str) -> _Builder:
    """Import the builder of *component*, with the first config of that component."""
    module, name = BUILDERS[component]
    return cast("_Builder", getattr(import_module(f"{__package__}.{module}"), name))


_Parts: TypeAlias = dict[str, tuple[DescribedPart, DiscoveryConfig]]
_HEATING = frozenset({"climate", "water_heater"})
_MAX_MEMBERS = 100
_SERVICE_TYPE = attrgetter("part.service_type")


def _with_members(described: DescribedPart, config: DiscoveryConfig) -> DescribedPart:
    """Return *described* with the members of a group, which its config names by their ``unique_id``."""
    members = config.values.get("group")
    listed = members[:_MAX_MEMBERS] if isinstance(members, list) else ()
    named = tuple([f"#{clean_text(entity_id)}" for entity_id in listed if isinstance(entity_id, str)])
    return described._replace(part=described.part.model_copy(update={"members": named}))


def _share_availability(
    parts: Sequence[DescribedPart], whole: Availability | None
) -> tuple[tuple[DescribedPart, ...], Availability | None]:
    """Return *parts*, and the availability of the *whole* device: the stated one, or that which all parts have."""
    if whole is None and all(part.availability == parts[0].availability for part in parts):
        whole = parts[0].availability
    if whole is None:
        return tuple(parts), None
    own = [part._replace(availability=None) if part.availability == whole else part for part in parts]
    return tuple(own), whole


def _describe(topic: str, config_topic: ConfigTopic, announced: Announced, parts: _Parts) -> DeviceAnnounced:
    common = announced.common
    device = cached_device(common.get("device"), common.get("origin"))
    if config_topic.component == DEVICE:
        whole = read_availability(DiscoveryConfig(config_topic.component, config_topic.object_id, announced.common))
        described, whole = _share_availability([part for part, _ in parts.values()], whole)
        key = config_topic.key
    else:
        ((part, config),) = parts.values()
        key, described, whole = config.discovery_id, (part,), cached_availability(config)
    facts: dict[str, str] = {}
    for part_id, (_, own) in parts.items():
        if "enabled_by_default" in own.values and not own.flag("enabled_by_default", default=True):
            facts[f"hidden {part_id}"] = "by default"
    lone_name = "" if device.identifiers else described[0].part.name or clean_text(config_topic.object_id)
    return DeviceAnnounced(
        key=key,
        convention="homeassistant",
        identifiers=device.identifiers,
        name=device.name or lone_name,
        parts=described,
        topic=topic,
        area=device.area,
        facts={**device.facts, **facts} if facts else device.facts,
        availability=whole,
        stale_after=TRACKER_SILENCE if "x_tracker" in map(_SERVICE_TYPE, described) else 0.0,
    )
