"""Table of the builder of each component. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.alarms import build_alarm_control_panel, build_siren
from homebot.conventions.homeassistant.climate import build_climate, build_humidifier, build_water_heater
from homebot.conventions.homeassistant.closures import build_cover, build_lock, build_valve
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.fan import build_fan
from homebot.conventions.homeassistant.light_basic import build_basic_light
from homebot.conventions.homeassistant.light_json import build_json_light
from homebot.conventions.homeassistant.light_template import build_template_light
from homebot.conventions.homeassistant.read_only import (
    build_camera,
    build_device_tracker,
    build_event,
    build_image,
    build_tag,
    build_trigger,
    build_update,
)
from homebot.conventions.homeassistant.robots import build_lawn_mower, build_vacuum
from homebot.conventions.homeassistant.sensors import build_binary_sensor, build_sensor
from homebot.conventions.homeassistant.settings import (
    build_button,
    build_moment,
    build_notify,
    build_number,
    build_scene,
    build_select,
    build_switch,
    build_text,
)
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["BUILDERS", "Builder", "build_light"]


def build_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp."""
    schema = config.text("schema", "basic")
    builder = _SCHEMAS.get(schema.lower())
    if builder is None:
        raise WireError(f"light: schema is {shown(schema)}, not basic, json or template")
    return builder(config)


_SCHEMAS: Mapping[str, Callable[[DiscoveryConfig], DescribedPart]] = MappingProxyType(
    {"basic": build_basic_light, "json": build_json_light, "template": build_template_light}
)


Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]
"""Makes a part of a component's config; raises WireError where Home Assistant would refuse the config."""

BUILDERS: Mapping[str, Builder] = MappingProxyType(
    {
        "alarm_control_panel": build_alarm_control_panel,
        "binary_sensor": build_binary_sensor,
        "button": build_button,
        "camera": build_camera,
        "climate": build_climate,
        "cover": build_cover,
        "date": build_moment,
        "datetime": build_moment,
        "device_automation": build_trigger,
        "device_tracker": build_device_tracker,
        "event": build_event,
        "fan": build_fan,
        "humidifier": build_humidifier,
        "image": build_image,
        "lawn_mower": build_lawn_mower,
        "light": build_light,
        "lock": build_lock,
        "notify": build_notify,
        "number": build_number,
        "scene": build_scene,
        "select": build_select,
        "sensor": build_sensor,
        "siren": build_siren,
        "switch": build_switch,
        "tag": build_tag,
        "text": build_text,
        "time": build_moment,
        "update": build_update,
        "vacuum": build_vacuum,
        "valve": build_valve,
        "water_heater": build_water_heater,
    }
)
"""By component. One that is not here is ignored quietly."""
