"""Table of the builder of each component, imported with the first config of that component. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TypeAlias, cast

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.lazy_names import lazy_names

__all__ = ["BUILDERS", "Builder", "builder_of"]

Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]
"""Makes a part of a component's config; raises WireError where Home Assistant would refuse the config."""

BUILDERS: Mapping[str, str] = {
    "alarm_control_panel": "build_alarm_control_panel",
    "binary_sensor": "build_binary_sensor",
    "button": "build_button",
    "camera": "build_camera",
    "climate": "build_climate",
    "cover": "build_cover",
    "date": "build_moment",
    "datetime": "build_moment",
    "device_automation": "build_trigger",
    "device_tracker": "build_device_tracker",
    "event": "build_event",
    "fan": "build_fan",
    "humidifier": "build_humidifier",
    "image": "build_image",
    "lawn_mower": "build_lawn_mower",
    "light": "build_light",
    "lock": "build_lock",
    "notify": "build_notify",
    "number": "build_number",
    "scene": "build_scene",
    "select": "build_select",
    "sensor": "build_sensor",
    "siren": "build_siren",
    "switch": "build_switch",
    "tag": "build_tag",
    "text": "build_text",
    "time": "build_moment",
    "update": "build_update",
    "vacuum": "build_vacuum",
    "valve": "build_valve",
    "water_heater": "build_water_heater",
}
"""Names of the builders by component. A component that is not here is ignored quietly."""


@lru_cache(maxsize=len(BUILDERS))
def builder_of(component: str) -> Builder:
    """Return the builder of *component*, which is one of :data:`BUILDERS`."""
    return cast("Builder", _load(BUILDERS[component]))


_PACKAGE = __name__.rpartition(".")[0]
_load = lazy_names(
    __name__,
    {
        f"{_PACKAGE}.alarm_control_panel": "build_alarm_control_panel",
        f"{_PACKAGE}.binary_sensor": "build_binary_sensor",
        f"{_PACKAGE}.button": "build_button build_scene",
        f"{_PACKAGE}.camera": "build_camera build_image",
        f"{_PACKAGE}.climate": "build_climate",
        f"{_PACKAGE}.cover": "build_cover",
        f"{_PACKAGE}.datetime_components": "build_moment",
        f"{_PACKAGE}.device_tracker": "build_device_tracker",
        f"{_PACKAGE}.event": "build_event build_tag build_trigger",
        f"{_PACKAGE}.fan": "build_fan",
        f"{_PACKAGE}.humidifier": "build_humidifier",
        f"{_PACKAGE}.lawn_mower": "build_lawn_mower",
        f"{_PACKAGE}.light": "build_light",
        f"{_PACKAGE}.lock": "build_lock",
        f"{_PACKAGE}.number": "build_number",
        f"{_PACKAGE}.select": "build_select",
        f"{_PACKAGE}.sensor": "build_sensor",
        f"{_PACKAGE}.siren": "build_siren",
        f"{_PACKAGE}.switch": "build_switch",
        f"{_PACKAGE}.text": "build_notify build_text",
        f"{_PACKAGE}.update": "build_update",
        f"{_PACKAGE}.vacuum": "build_vacuum",
        f"{_PACKAGE}.valve": "build_valve",
        f"{_PACKAGE}.water_heater": "build_water_heater",
    },
)
