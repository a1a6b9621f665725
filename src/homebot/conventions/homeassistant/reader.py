"""Reader of Home Assistant's discovery configs: configs in, descriptions out. Pure.

A large house has five times as many configs as shapes of them, such as one shape for the batteries of all devices: of
parts that differ in nothing but names and topics, one is built, and the others are made after it.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from typing import NamedTuple, TypeAlias, cast

from pydantic_core import to_json

from homebot.conventions.description import (
    AnnouncementEvent,
    Availability,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
)
from homebot.conventions.homeassistant.announcement import Announced, read_announcement
from homebot.conventions.homeassistant.components import BUILDERS
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.device import cached_availability, device_in, read_availability
from homebot.conventions.homeassistant.topics import DEVICE, ConfigTopic, parse_config_topic
from homebot.conventions.part_builder import is_movable, moved
from homebot.conventions.payload import clean_text
from homebot.errors import WireError
from homebot.support.bounded_map import BoundedMap

__all__ = ["HomeAssistantReader", "PartShapes", "builder_of"]

SHAPED = frozenset({"binary_sensor", "button", "number", "select", "sensor", "switch", "text"})
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
_LONGEST_SHAPE = 2048


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
            return moved(first, own, part_id=config.part_id, name=config.clean_text("name"))
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
    if len(text) > _LONGEST_SHAPE:
        return None
    return _Shape(config.component, config.is_secret, tuple(names), tuple(places), text)


class HomeAssistantReader:
    """Reader of configs; counts the invalid components of a device with valid ones."""

    def __init__(self, prefixes: tuple[str, ...]) -> None:
        self.rejected = 0
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
        parts = self._parts(config_topic, announced)
        if not parts:
            return (DeviceWithdrawn(config_topic.key, "it has no components left"),)
        return (_described(topic, config_topic, announced, parts),)

    def _parts(self, config_topic: ConfigTopic, announced: Announced) -> _Parts:
        """Build the parts, without invalid components of a whole device, and without codes and passwords."""
        parts: _Parts = {}
        broken: WireError | None = None
        for config in announced.components:
            try:
                build = builder_of(config.component)
                part = self._shapes.part(config, build) if config.component in SHAPED else build(config)
                if config_topic.component == DEVICE:
                    part = part._replace(availability=cached_availability(config))
            except WireError as error:
                if config_topic.component != DEVICE:
                    raise
                self.rejected += 1
                broken = error
                continue
            if not part.part.capabilities and config.is_secret:
                continue
            if part.part.id in parts:
                part = part._replace(part=part.part.model_copy(update={"id": config.discovery_id}))
            parts[part.part.id] = part, config
        if broken is not None and not parts:
            self.rejected -= 1
            raise broken
        return parts


_Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]
"""Builds the part of a component's config; raises WireError if Home Assistant would refuse the config."""


@lru_cache(maxsize=len(BUILDERS))
def builder_of(component: str) -> _Builder:
    """Import the builder of *component*, with the first config of that component."""
    module, name = BUILDERS[component]
    return cast("_Builder", getattr(import_module(f"{__package__}.{module}"), name))


_Parts: TypeAlias = dict[str, tuple[DescribedPart, DiscoveryConfig]]
_MAX_MEMBERS = 100


def _described(topic: str, config_topic: ConfigTopic, announced: Announced, parts: _Parts) -> DeviceAnnounced:
    device = device_in(to_json((announced.device, announced.origin)))
    if config_topic.component == DEVICE:
        key, (described, whole) = config_topic.key, _shared_availability(config_topic, announced, parts)
    else:
        ((part, config),) = parts.values()
        key, described, whole = config.discovery_id, (part,), cached_availability(config)
    facts = _facts(parts)
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
    )


def _shared_availability(
    config_topic: ConfigTopic, announced: Announced, parts: _Parts
) -> tuple[tuple[DescribedPart, ...], Availability | None]:
    """Return the parts of a whole device without the shared availability, and that availability."""
    whole = read_availability(DiscoveryConfig(config_topic.component, config_topic.object_id, announced.common))
    described = tuple([part for part, _ in parts.values()])
    if whole is None and all(part.availability == described[0].availability for part in described):
        whole = described[0].availability
    if whole is not None:
        described = tuple([one._replace(availability=None) if one.availability == whole else one for one in described])
    return described, whole


def _facts(parts: _Parts) -> dict[str, str]:
    """Return the facts of parts: hidden ones, and the members of groups."""
    facts = {}
    for part_id, (_, config) in parts.items():
        if not config.flag("enabled_by_default", default=True):
            facts[f"hidden {part_id}"] = "by default"
        members = config.values.get("group")
        if isinstance(members, list) and members:
            named = [clean_text(one) for one in members[:_MAX_MEMBERS] if isinstance(one, str)]
            facts[f"group {part_id}"] = " ".join(named)
    return facts
