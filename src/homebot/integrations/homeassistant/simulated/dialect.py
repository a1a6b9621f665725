"""Devices that announce themselves by Home Assistant's MQTT discovery, as firmware like ESPHome does.

A device ``NODE`` publishes its state as JSON on ``NODE/state``, retained, and its availability on ``NODE/status``.
It takes commands on ``NODE/set`` and, for numbers of their own, ``NODE/set_position`` or ``NODE/set_temperature``. Its
announcement is one config of its component, or one of the whole device.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.wire import (
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

Fields: TypeAlias = dict[str, object]


@dataclass(frozen=True, slots=True)
class ComponentTemplate:
    """A component.

    Attributes:
        config: Its options; ``~`` is the base of its topics.
        state: Returns the payload of a state.
        levels: Last levels of the topics on which it takes commands.
    """

    component: str
    config: Mapping[str, object]
    state: Callable[[DeviceState], Fields]
    levels: tuple[str, ...] = ()


def _light_state(lamp: DeviceState) -> Fields:
    return {
        "state": "ON" if lamp.is_on else "OFF",
        "brightness": max(1, round(lamp.brightness * 255)),
        "color_mode": "color_temp",
        "color_temp": round(1e6 / lamp.kelvin),
    }


def _cover(device_class: str) -> ComponentTemplate:
    return ComponentTemplate("cover", {**_COVER, "device_class": device_class}, _cover_state, ("set", "set_position"))


def _cover_state(motor: DeviceState) -> Fields:
    rests = "open" if motor.position else "closed"
    return {"state": {1: "opening", -1: "closing"}.get(motor.way, rests), "position": round(motor.position * 100)}


def _binary_sensor(device_class: str, on: str) -> ComponentTemplate:
    return ComponentTemplate(
        "binary_sensor",
        {"device_class": device_class, "state_topic": "~/state", "value_template": "{{ value_json.state }}"},
        lambda sensor: {"state": "ON" if sensor.text == on else "OFF"},
    )


def _sensor(device_class: str, unit: str) -> ComponentTemplate:
    config = {
        "device_class": device_class,
        "unit_of_measurement": unit,
        "state_class": "measurement",
        "state_topic": "~/state",
        "value_template": "{{ value_json.value }}",
    }
    return ComponentTemplate("sensor", config, lambda sensor: {"value": sensor.value})


def _climate_state(thermostat: DeviceState) -> Fields:
    return {
        "mode": "heat",
        "action": "heating" if thermostat.heats else "idle",
        "temperature": round(thermostat.celsius, 1),
        "target": round(thermostat.target, 3),
    }


_LIGHT = {
    "schema": "json",
    "state_topic": "~/state",
    "command_topic": "~/set",
    "brightness": True,
    "supported_color_modes": ["color_temp"],
    "min_mireds": 112,
    "max_mireds": 666,
}
_LOCK = {"state_topic": "~/state", "value_template": "{{ value_json.state }}", "command_topic": "~/set"}
_COVER = {
    **_LOCK,
    "position_topic": "~/state",
    "position_template": "{{ value_json.position }}",
    "set_position_topic": "~/set_position",
}
_CLIMATE = {
    "modes": ["heat"],
    "mode_state_topic": "~/state",
    "mode_state_template": "{{ value_json.mode }}",
    "action_topic": "~/state",
    "action_template": "{{ value_json.action }}",
    "current_temperature_topic": "~/state",
    "current_temperature_template": "{{ value_json.temperature }}",
    "temperature_state_topic": "~/state",
    "temperature_state_template": "{{ value_json.target }}",
    "temperature_command_topic": "~/set_temperature",
    "min_temp": 5,
    "max_temp": 30,
    "temp_step": 0.5,
    "temperature_unit": "C",
}

COMPONENTS: Mapping[str, ComponentTemplate] = {
    "lamp": ComponentTemplate("light", _LIGHT, _light_state, ("set",)),
    "window": _cover("window"),
    "cover": _cover("shutter"),
    "lock": ComponentTemplate("lock", _LOCK, lambda lock: {"state": lock.text.upper()}, ("set",)),
    "contact": _binary_sensor("door", "open"),
    "motion": _binary_sensor("motion", "motion"),
    "presence": _binary_sensor("presence", "motion"),
    "lux": _sensor("illuminance", "lx"),
    "power_meter": _sensor("power", "W"),
    "thermostat": ComponentTemplate("climate", _CLIMATE, _climate_state, ("set_temperature",)),
}
"""By kind."""


LEVELS = 255
_SHORT = {"identifiers": "ids", "connections": "cns", "manufacturer": "mf", "model": "mdl", "suggested_area": "sa"}


class HomeAssistantDialect(Dialect):
    """Devices of Home Assistant's discovery: all kinds but robots, for which there is no component.

    Attributes:
        whole_devices: Whether they announce themselves as whole devices, with abbreviated keys, rather than as single
            components.
    """

    whole_devices: ClassVar[bool] = False
    kinds = frozenset(COMPONENTS)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where it takes commands; sensors take none."""
        return tuple(f"{node_name(device)}/{level}" for level in COMPONENTS[device.kind].levels)

    def availability(self, device: SimulatedDeviceInfo) -> tuple[str, bytes, bytes]:
        """Return the topic of its status."""
        return f"{node_name(device)}/status", b"online", b"offline"

    def announcement(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return its configuration, with abbreviated keys for a whole device."""
        node, part = node_name(device), COMPONENTS[device.kind]
        digits = hardware_address(device)
        about = {
            "identifiers": [node],
            "connections": [["mac", ":".join(digits[at : at + 2] for at in range(0, 12, 2))]],
            "name": device.device_id,
            "manufacturer": "homebot",
            "model": f"simulated {device.kind}",
            "suggested_area": device.room,
        }
        config = {"~": node, **part.config, "name": None}
        status, topic = f"{node}/status", f"homeassistant/{part.component}/{node}/config"
        message: Fields = {**config, "unique_id": f"{node}_{part.component}", "availability_topic": status}
        message["device"] = about
        if self.whole_devices:
            topic = f"homeassistant/device/{node}/config"
            message = {
                "dev": {_SHORT.get(key, key): value for key, value in about.items()},
                "o": {"name": "homebot's simulated house"},
                "avty_t": status,
                "cmps": {device.kind: {**config, "p": part.component, "uniq_id": f"{node}_main"}},
            }
        return (OutgoingMessage(topic, as_json(message), retain=True),)

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


class HomeAssistantDeviceDialect(HomeAssistantDialect):
    """Devices that announce themselves as whole devices."""

    whole_devices = True
