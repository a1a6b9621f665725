"""Devices that announce themselves by Home Assistant's MQTT discovery, as firmware like ESPHome does.

A device ``NODE`` publishes its state as JSON on ``NODE/state``, retained, and its availability on ``NODE/status``.
It takes commands on ``NODE/set`` and, for numbers of their own, ``NODE/set_position`` or ``NODE/set_temperature``. Its
announcement is one config of its component, or one of the whole device.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.dialects.wire import (
    as_json,
    as_object,
    as_text,
    device_orders,
    hardware_address,
    mired_kelvin,
    node_name,
    scaled,
)
from homebot.support.numbers import to_number

__all__ = ["COMPONENTS", "ComponentTemplate", "HomeAssistantDialect"]

Fields: TypeAlias = dict[str, object]


@dataclass(frozen=True, slots=True)
class ComponentTemplate:
    """A component.

    Attributes:
        config: Returns its options for a topic prefix.
        state: Returns the payload of a state.
        levels: Last levels of the topics on which it takes commands.
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


LEVELS = 255


class HomeAssistantDialect(Dialect):
    """Devices of Home Assistant's discovery.

    Args:
        whole_devices: Whether they announce themselves as whole devices, with abbreviated keys, rather than as single
            components.
    """

    def __init__(self, *, whole_devices: bool = False, prefix: str = "homeassistant") -> None:
        self._whole_devices = whole_devices
        self._prefix = prefix

    @property
    def kinds(self) -> frozenset[str]:
        """All but robots, for which there is no component."""
        return frozenset(COMPONENTS)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where it takes commands; sensors take none."""
        return tuple(f"{node_name(device)}/{level}" for level in COMPONENTS[device.kind].levels)

    def availability(self, device: SimulatedDeviceInfo) -> tuple[str, bytes, bytes]:
        """Return the topic of its status."""
        return f"{node_name(device)}/status", b"online", b"offline"

    def announcement(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return its configuration."""
        return (self._whole(device) if self._whole_devices else self._single(device),)

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its state, kept."""
        payload = as_json(COMPONENTS[device.kind].state(state))
        return (OutgoingMessage(f"{node_name(device)}/state", payload, retain=True),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the command in a payload of Home Assistant."""
        text, level = as_text(payload), topic.rpartition("/")[2]
        fields = as_object(payload) if device.kind == "lamp" else {}
        return device_orders(
            device.kind,
            is_on={"ON": True, "OFF": False}.get(str(fields.get("state"))),
            brightness=scaled(fields.get("brightness"), LEVELS),
            kelvin=mired_kelvin(fields.get("color_temp")),
            position=scaled(text, 100) if level == "set_position" else None,
            action=text if level == "set" and (device.kind != "lock" or text.isupper()) else "",
            target=to_number(text) if level == "set_temperature" else None,
        )

    def _single(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        node, part = node_name(device), COMPONENTS[device.kind]
        config = {
            **part.config(node),
            "name": None,
            "unique_id": f"{node}_{part.component}",
            "availability_topic": f"{node}/status",
            "device": {
                "identifiers": [node],
                "connections": [["mac", _mac(device)]],
                "name": device.device_id,
                "manufacturer": "homebot",
                "model": f"simulated {device.kind}",
                "suggested_area": device.room,
            },
        }
        return OutgoingMessage(f"{self._prefix}/{part.component}/{node}/config", as_json(config), retain=True)

    def _whole(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        node, part = node_name(device), COMPONENTS[device.kind]
        config = {
            "dev": {
                "ids": [node],
                "cns": [["mac", _mac(device)]],
                "name": device.device_id,
                "mf": "homebot",
                "mdl": f"simulated {device.kind}",
                "sa": device.room,
            },
            "o": {"name": "homebot's simulated house"},
            "avty_t": f"{node}/status",
            "cmps": {device.kind: {**part.config(node), "p": part.component, "name": None, "uniq_id": f"{node}_main"}},
        }
        return OutgoingMessage(f"{self._prefix}/device/{node}/config", as_json(config), retain=True)


def _mac(device: SimulatedDeviceInfo) -> str:
    digits = hardware_address(device)
    return ":".join(digits[at : at + 2] for at in range(0, 12, 2))
