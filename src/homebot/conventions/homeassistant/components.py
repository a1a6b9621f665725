"""Table of the builder of each component. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.alarm_control_panel import build_alarm_control_panel
from homebot.conventions.homeassistant.binary_sensor import build_binary_sensor
from homebot.conventions.homeassistant.button import build_button, build_scene
from homebot.conventions.homeassistant.camera import build_camera, build_image
from homebot.conventions.homeassistant.climate import build_climate
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.cover import build_cover
from homebot.conventions.homeassistant.datetime_components import build_moment
from homebot.conventions.homeassistant.device_tracker import build_device_tracker
from homebot.conventions.homeassistant.event import build_event, build_tag, build_trigger
from homebot.conventions.homeassistant.fan import build_fan
from homebot.conventions.homeassistant.humidifier import build_humidifier
from homebot.conventions.homeassistant.lawn_mower import build_lawn_mower
from homebot.conventions.homeassistant.light import build_light
from homebot.conventions.homeassistant.lock import build_lock
from homebot.conventions.homeassistant.number import build_number
from homebot.conventions.homeassistant.select import build_select
from homebot.conventions.homeassistant.sensor import build_sensor
from homebot.conventions.homeassistant.siren import build_siren
from homebot.conventions.homeassistant.switch import build_switch
from homebot.conventions.homeassistant.text import build_notify, build_text
from homebot.conventions.homeassistant.update import build_update
from homebot.conventions.homeassistant.vacuum import build_vacuum
from homebot.conventions.homeassistant.valve import build_valve
from homebot.conventions.homeassistant.water_heater import build_water_heater

__all__ = ["BUILDERS", "Builder"]

Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]
"""Makes a part of a component's config; raises WireError where Home Assistant would refuse the config."""

BUILDERS: Mapping[str, Builder] = {
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
"""By component. One that is not here is ignored quietly."""
