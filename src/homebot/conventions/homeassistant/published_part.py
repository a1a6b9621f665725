"""Entities that Home Assistant shall make of an exposed part. Pure."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from homebot.conventions.homeassistant.published_climate import (
    publish_climate,
    publish_humidifier,
    publish_water_heater,
)
from homebot.conventions.homeassistant.published_controls import (
    publish_alarm,
    publish_cover,
    publish_fan,
    publish_lock,
    publish_mower,
    publish_siren,
    publish_vacuum,
    publish_valve,
)
from homebot.conventions.homeassistant.published_entity import Available, EntityTopics, PublishedEntity
from homebot.conventions.homeassistant.published_light import publish_light
from homebot.conventions.homeassistant.published_single import publish_single
from homebot.devices.part import Part

__all__ = ["publish_part"]


def publish_part(part: Part, topics: EntityTopics) -> tuple[PublishedEntity, ...]:
    """Return the entities of *part*: first what it is there for, then what is left, one by one."""
    available: Available = {one.name: one for one in part.capabilities}
    found: list[PublishedEntity] = []
    for publish in _WHOLE:
        found.extend(publish(part, available, topics))
    for capability in available.values():
        found.extend(publish_single(part, capability, topics))
    return tuple(found)


_Publish: TypeAlias = Callable[[Part, Available, EntityTopics], tuple[PublishedEntity, ...]]
_WHOLE: tuple[_Publish, ...] = (
    publish_light,
    publish_fan,
    publish_siren,
    publish_climate,
    publish_water_heater,
    publish_humidifier,
    publish_lock,
    publish_valve,
    publish_cover,
    publish_vacuum,
    publish_mower,
    publish_alarm,
)
"""Each takes what belongs together; what a valve takes as its position is no cover's."""
