"""The component of Home Assistant's discovery that each kind of device is, with its options and its state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from homebot.house.device_state import DeviceState

__all__ = ["COMPONENTS", "ComponentTemplate"]

Fields: TypeAlias = dict[str, object]


@dataclass(frozen=True, slots=True)
class ComponentTemplate:
    """A component.

    Attributes:
        component: Its name.
        config: Returns its options, for a device whose topics begin with the text given.
        state: Returns what a device in some condition says.
        levels: Last levels of the topics on which it hears.
    """

    component: str
    config: Callable[[str], Fields]
    state: Callable[[DeviceState], Fields]
    levels: tuple[str, ...] = ()


def _light(node: str) -> Fields:
    return {
        "schema": "json",
        "state_topic": f"{node}/state",
        "command_topic": f"{node}/set",
        "brightness": True,
        "supported_color_modes": ["color_temp"],
        "min_mireds": 112,
        "max_mireds": 666,
    }


def _light_state(lamp: DeviceState) -> Fields:
    return {
        "state": "ON" if lamp.is_on else "OFF",
        "brightness": max(1, round(lamp.brightness * 255)),
        "color_mode": "color_temp",
        "color_temp": round(1e6 / lamp.kelvin),
    }


def _cover(device_class: str) -> Callable[[str], Fields]:
    def config(node: str) -> Fields:
        return {
            "device_class": device_class,
            "state_topic": f"{node}/state",
            "value_template": "{{ value_json.state }}",
            "command_topic": f"{node}/set",
            "position_topic": f"{node}/state",
            "position_template": "{{ value_json.position }}",
            "set_position_topic": f"{node}/set_position",
        }

    return config


def _cover_state(motor: DeviceState) -> Fields:
    rests = "open" if motor.position else "closed"
    return {"state": {1: "opening", -1: "closing"}.get(motor.way, rests), "position": round(motor.position * 100)}


def _lock(node: str) -> Fields:
    return {
        "state_topic": f"{node}/state",
        "value_template": "{{ value_json.state }}",
        "command_topic": f"{node}/set",
    }


def _binary_sensor(device_class: str) -> Callable[[str], Fields]:
    def config(node: str) -> Fields:
        topic = f"{node}/state"
        return {"device_class": device_class, "state_topic": topic, "value_template": "{{ value_json.state }}"}

    return config


def _sensor(device_class: str, unit: str) -> Callable[[str], Fields]:
    def config(node: str) -> Fields:
        return {
            "device_class": device_class,
            "unit_of_measurement": unit,
            "state_class": "measurement",
            "state_topic": f"{node}/state",
            "value_template": "{{ value_json.value }}",
        }

    return config


def _climate(node: str) -> Fields:
    topic = f"{node}/state"
    return {
        "modes": ["heat"],
        "mode_state_topic": topic,
        "mode_state_template": "{{ value_json.mode }}",
        "action_topic": topic,
        "action_template": "{{ value_json.action }}",
        "current_temperature_topic": topic,
        "current_temperature_template": "{{ value_json.temperature }}",
        "temperature_state_topic": topic,
        "temperature_state_template": "{{ value_json.target }}",
        "temperature_command_topic": f"{node}/set_temperature",
        "min_temp": 5,
        "max_temp": 30,
        "temp_step": 0.5,
        "temperature_unit": "C",
    }


def _climate_state(thermostat: DeviceState) -> Fields:
    return {
        "mode": "heat",
        "action": "heating" if thermostat.heats else "idle",
        "temperature": round(thermostat.celsius, 1),
        "target": round(thermostat.target, 3),
    }


_POSITIONED = ("set", "set_position")

COMPONENTS: Mapping[str, ComponentTemplate] = MappingProxyType(
    {
        "lamp": ComponentTemplate("light", _light, _light_state, ("set",)),
        "window": ComponentTemplate("cover", _cover("window"), _cover_state, _POSITIONED),
        "cover": ComponentTemplate("cover", _cover("shutter"), _cover_state, _POSITIONED),
        "lock": ComponentTemplate("lock", _lock, lambda lock: {"state": lock.text.upper()}, ("set",)),
        "contact": ComponentTemplate(
            "binary_sensor", _binary_sensor("door"), lambda door: {"state": "ON" if door.text == "open" else "OFF"}
        ),
        "motion": ComponentTemplate(
            "binary_sensor", _binary_sensor("motion"), lambda room: {"state": "ON" if room.text == "motion" else "OFF"}
        ),
        "lux": ComponentTemplate("sensor", _sensor("illuminance", "lx"), lambda lux: {"value": lux.value}),
        "power_meter": ComponentTemplate("sensor", _sensor("power", "W"), lambda meter: {"value": meter.value}),
        "thermostat": ComponentTemplate("climate", _climate, _climate_state, ("set_temperature",)),
    }
)
"""By kind."""
