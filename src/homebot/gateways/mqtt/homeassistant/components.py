"""Which builder understands which component: one line each. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from homebot.gateways.mqtt.description import DescribedPart
from homebot.gateways.mqtt.homeassistant.alarm_control_panel import build_alarm_control_panel
from homebot.gateways.mqtt.homeassistant.binary_sensor import build_binary_sensor
from homebot.gateways.mqtt.homeassistant.button import build_button, build_scene
from homebot.gateways.mqtt.homeassistant.camera import build_camera, build_image
from homebot.gateways.mqtt.homeassistant.climate import build_climate
from homebot.gateways.mqtt.homeassistant.config import DiscoveryConfig
from homebot.gateways.mqtt.homeassistant.cover import build_cover
from homebot.gateways.mqtt.homeassistant.device_tracker import build_device_tracker
from homebot.gateways.mqtt.homeassistant.event import build_event, build_tag, build_trigger
from homebot.gateways.mqtt.homeassistant.fan import build_fan
from homebot.gateways.mqtt.homeassistant.humidifier import build_humidifier
from homebot.gateways.mqtt.homeassistant.lawn_mower import build_lawn_mower
from homebot.gateways.mqtt.homeassistant.light import build_light
from homebot.gateways.mqtt.homeassistant.lock import build_lock
from homebot.gateways.mqtt.homeassistant.moment import build_moment
from homebot.gateways.mqtt.homeassistant.number import build_number
from homebot.gateways.mqtt.homeassistant.select import build_select
from homebot.gateways.mqtt.homeassistant.sensor import build_sensor
from homebot.gateways.mqtt.homeassistant.siren import build_siren
from homebot.gateways.mqtt.homeassistant.switch import build_switch
from homebot.gateways.mqtt.homeassistant.text import build_notify, build_text
from homebot.gateways.mqtt.homeassistant.update import build_update
from homebot.gateways.mqtt.homeassistant.vacuum import build_vacuum
from homebot.gateways.mqtt.homeassistant.valve import build_valve
from homebot.gateways.mqtt.homeassistant.water_heater import build_water_heater

__all__ = ["BUILDERS", "Builder"]

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
