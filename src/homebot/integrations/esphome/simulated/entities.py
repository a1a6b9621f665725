"""Entities of simulated ESPHome devices: how each kind is listed, reported and commanded. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from homebot.house.dialect import DeviceState
from homebot.house.simulated_device import number_text
from homebot.house.wire import lamp_order

Fields: TypeAlias = Mapping[str, Any]
MIRED = 1e6
_COLOR_TEMPERATURE = 11


@dataclass(frozen=True, slots=True)
class EntityTemplate:
    """The entity of a kind of device.

    Attributes:
        component: The middle of the names of its messages: ``Light``.
        listed: The fields with which it is listed.
        commands: The commands in the fields of a command; sensors take none.
    """

    component: str
    listed: Fields
    state: Callable[[DeviceState], Fields]
    commands: Callable[[Fields], tuple[str, ...]] = lambda _fields: ()


def _lamp_state(lamp: DeviceState) -> Fields:
    return {
        "state": lamp.is_on,
        "brightness": lamp.brightness,
        "color_mode": _COLOR_TEMPERATURE,
        "color_temperature": MIRED / lamp.kelvin,
    }


def _lamp_commands(fields: Fields) -> tuple[str, ...]:
    mired = fields["color_temperature"] if fields["has_color_temperature"] else 0.0
    return lamp_order(
        is_on=fields["state"] if fields["has_state"] else None,
        brightness=fields["brightness"] if fields["has_brightness"] else None,
        kelvin=MIRED / mired if mired > 0 else None,
    )


def _motor_commands(fields: Fields) -> tuple[str, ...]:
    if fields["stop"]:
        return ("stop",)
    return (number_text(fields["position"]),) if fields["has_position"] else ()


def _motor(device_class: str) -> EntityTemplate:
    return EntityTemplate(
        "Cover",
        {"supports_position": True, "supports_stop": True, "device_class": device_class},
        lambda motor: {"position": motor.position, "current_operation": {1: 1, -1: 2}.get(motor.way, 0)},
        _motor_commands,
    )


def _binary_sensor(device_class: str, text: str) -> EntityTemplate:
    return EntityTemplate("BinarySensor", {"device_class": device_class}, lambda state: {"state": state.text == text})


def _sensor(device_class: str, unit: str) -> EntityTemplate:
    listed = {"device_class": device_class, "unit_of_measurement": unit, "state_class": 1}
    return EntityTemplate("Sensor", listed, lambda sensor: {"state": sensor.value})


_LOCK_STATES = {"locked": 1, "unlocked": 2, "jammed": 3, "locking": 4, "unlocking": 5}
_HEAT = 3
_MEASURES_AND_ACTS = 1 | 32

ENTITIES: Mapping[str, EntityTemplate] = {
    "lamp": EntityTemplate(
        "Light",
        {"supported_color_modes": [_COLOR_TEMPERATURE], "min_mireds": 25.0, "max_mireds": 666.0},
        _lamp_state,
        _lamp_commands,
    ),
    "window": _motor("window"),
    "cover": _motor("shutter"),
    "lock": EntityTemplate(
        "Lock",
        {},
        lambda lock: {"state": _LOCK_STATES.get(lock.text, 0)},
        lambda fields: ({0: "unlock", 1: "lock"}.get(fields["command"], ""),),
    ),
    "switch": EntityTemplate(
        "Switch",
        {"device_class": "outlet"},
        lambda switch: {"state": switch.text == "on"},
        lambda fields: ("on" if fields["state"] else "off",),
    ),
    "contact": _binary_sensor("door", "open"),
    "motion": _binary_sensor("motion", "motion"),
    "lux": _sensor("illuminance", "lx"),
    "power_meter": _sensor("power", "W"),
    "thermostat": EntityTemplate(
        "Climate",
        {
            "feature_flags": _MEASURES_AND_ACTS,
            "supports_current_temperature": True,
            "supports_action": True,
            "supported_modes": [_HEAT],
            "visual_min_temperature": 5.0,
            "visual_max_temperature": 30.0,
        },
        lambda state: {
            "mode": _HEAT,
            "action": _HEAT if state.heats else 4,
            "current_temperature": round(state.celsius, 1),
            "target_temperature": state.target,
        },
        lambda fields: (number_text(fields["target_temperature"]),) if fields["has_target_temperature"] else (),
    ),
}
"""By kind; a switch is no kind of the simulated house, but of tests."""
