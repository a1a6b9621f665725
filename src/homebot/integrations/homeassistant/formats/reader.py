"""Reader of Home Assistant's discovery configs: configs in, descriptions out. Pure.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from operator import attrgetter
from typing import TypeAlias, cast

from pydantic_core import to_json

from homebot.conventions.description import (
    TRACKER_SILENCE,
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
)
from homebot.conventions.payload import clean_text
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.announcement import Announced, read_announcement
from homebot.integrations.homeassistant.formats.components import BUILDERS
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.device import cached_availability, device_in, read_availability
from homebot.integrations.homeassistant.formats.shapes import SHAPED, PartShapes
from homebot.integrations.homeassistant.formats.topics import DEVICE, ConfigTopic, parse_config_topic


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
        return (_described(topic, config_topic, announced, parts), *problems)

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
                    members = config.values.get("group")
                    listed = members[:_MAX_MEMBERS] if isinstance(members, list) else ()
                    named = tuple([f"#{clean_text(entity_id)}" for entity_id in listed if isinstance(entity_id, str)])
                    part = part._replace(part=part.part.model_copy(update={"members": named}))
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


def _described(topic: str, config_topic: ConfigTopic, announced: Announced, parts: _Parts) -> DeviceAnnounced:
    common = announced.common
    device = device_in(to_json((common.get("device"), common.get("origin"))))
    if config_topic.component == DEVICE:
        whole = read_availability(DiscoveryConfig(config_topic.component, config_topic.object_id, announced.common))
        described = tuple([part for part, _ in parts.values()])
        if whole is None and all(part.availability == described[0].availability for part in described):
            whole = described[0].availability
        if whole is not None:
            described = tuple(
                [
                    announced._replace(availability=None) if announced.availability == whole else announced
                    for announced in described
                ]
            )
        key = config_topic.key
    else:
        ((part, config),) = parts.values()
        key, described, whole = config.discovery_id, (part,), cached_availability(config)
    facts = {}
    for part_id, (_, part_config) in parts.items():
        if not part_config.flag("enabled_by_default", default=True):
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
