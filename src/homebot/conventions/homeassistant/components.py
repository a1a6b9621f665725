"""Table of the builder of each component, imported with the first config of that component. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib import import_module
from typing import TypeAlias, cast

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig

__all__ = ["BUILDERS", "Builder", "builder_of"]

Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]
"""Builds the part of a component's config; raises WireError if Home Assistant would refuse the config."""

BUILDERS: Mapping[str, tuple[str, str]] = {
    "alarm_control_panel": ("locks", "build_alarm_control_panel"),
    "binary_sensor": ("sensors", "build_binary_sensor"),
    "button": ("settings", "build_button"),
    "camera": ("sensors", "build_camera"),
    "climate": ("climate", "build_climate"),
    "cover": ("cover", "build_cover"),
    "date": ("settings", "build_moment"),
    "datetime": ("settings", "build_moment"),
    "device_automation": ("sensors", "build_trigger"),
    "device_tracker": ("sensors", "build_device_tracker"),
    "event": ("sensors", "build_event"),
    "fan": ("appliances", "build_fan"),
    "humidifier": ("appliances", "build_humidifier"),
    "image": ("sensors", "build_image"),
    "lawn_mower": ("appliances", "build_lawn_mower"),
    "light": ("light", "build_light"),
    "lock": ("locks", "build_lock"),
    "notify": ("settings", "build_notify"),
    "number": ("settings", "build_number"),
    "scene": ("settings", "build_scene"),
    "select": ("settings", "build_select"),
    "sensor": ("sensors", "build_sensor"),
    "siren": ("appliances", "build_siren"),
    "switch": ("settings", "build_switch"),
    "tag": ("sensors", "build_tag"),
    "text": ("settings", "build_text"),
    "time": ("settings", "build_moment"),
    "update": ("sensors", "build_update"),
    "vacuum": ("appliances", "build_vacuum"),
    "valve": ("valve", "build_valve"),
    "water_heater": ("appliances", "build_water_heater"),
}
"""Module and builder by component. Other components are ignored without a log line."""


@lru_cache(maxsize=len(BUILDERS))
def builder_of(component: str) -> Builder:
    """Import the builder of *component*, one of :data:`BUILDERS`."""
    module, name = BUILDERS[component]
    return cast("Builder", getattr(import_module(f"{__package__}.{module}"), name))
