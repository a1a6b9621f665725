"""The Homie nodes that each kind of device has, with their properties and values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.house.device_state import DeviceState
from homebot.house.simulated_device import number_text

__all__ = ["NODES", "SimulatedHomieNode"]

PROFILE = "hc-smarthome/v2/cap"


@dataclass(frozen=True, slots=True)
class SimulatedHomieNode:
    """A node.

    Attributes:
        type: The capability that it is.
        properties: What can be read or set.
        values: Returns the values that a device in some condition says.
    """

    type: str
    properties: Mapping[str, Mapping[str, object]]
    values: Callable[[DeviceState], Mapping[str, str]]

    def description(self) -> dict[str, object]:
        """Return it as the device's description has it."""
        return {"type": f"{PROFILE}/{self.type}", "properties": dict(self.properties)}


_PERCENT = {"datatype": "integer", "format": "0:100", "unit": "%", "settable": True}
_DIRECTION = {"datatype": "enum", "format": "up,down,stop", "settable": True, "retained": False}
_TARGET = {"datatype": "float", "format": "5:30:0.5", "unit": "°C", "settable": True}
_WARMTH = {"datatype": "integer", "format": "112:666", "unit": "MK⁻¹", "settable": True}

_LAMP = {
    "switch": SimulatedHomieNode(
        "switch", {"state": {"datatype": "boolean", "settable": True}}, lambda lamp: {"state": _boolean(lamp.is_on)}
    ),
    "level": SimulatedHomieNode(
        "level", {"value": _PERCENT}, lambda lamp: {"value": number_text(lamp.brightness * 100, 0)}
    ),
    "color": SimulatedHomieNode(
        "color", {"color-temperature": _WARMTH}, lambda lamp: {"color-temperature": number_text(1e6 / lamp.kelvin, 0)}
    ),
}
_MOTOR = {
    "shutter": SimulatedHomieNode(
        "shutter",
        {"position": _PERCENT, "action": _DIRECTION},
        lambda motor: {"position": number_text(motor.position * 100, 0)},
    )
}

NODES: Mapping[str, Mapping[str, SimulatedHomieNode]] = MappingProxyType(
    {
        "lamp": _LAMP,
        "window": _MOTOR,
        "cover": _MOTOR,
        "lock": {
            "lock": SimulatedHomieNode(
                "lock",
                {"state": {"datatype": "boolean", "settable": True}},
                lambda lock: {"state": _boolean(lock.text == "locked")},
            )
        },
        "contact": {
            "contact": SimulatedHomieNode(
                "contact", {"state": {"datatype": "boolean"}}, lambda door: {"state": _boolean(door.text == "open")}
            )
        },
        "motion": {
            "motion": SimulatedHomieNode(
                "motion", {"motion": {"datatype": "boolean"}}, lambda room: {"motion": _boolean(room.text == "motion")}
            )
        },
        "lux": {
            "illuminance": SimulatedHomieNode(
                "illuminance",
                {"illuminance": {"datatype": "float", "unit": "lx"}},
                lambda lux: {"illuminance": number_text(lux.value)},
            )
        },
        "power_meter": {
            "powermeter": SimulatedHomieNode(
                "powermeter",
                {"power": {"datatype": "float", "unit": "W"}},
                lambda meter: {"power": number_text(meter.value)},
            )
        },
        "thermostat": {
            "thermostat": SimulatedHomieNode(
                "thermostat", {"set-temperature": _TARGET}, lambda room: {"set-temperature": number_text(room.target)}
            ),
            "climate": SimulatedHomieNode(
                "climate",
                {"temperature": {"datatype": "float", "unit": "°C"}},
                lambda room: {"temperature": number_text(room.celsius, 1)},
            ),
        },
    }
)
"""By kind and by the node's id."""


def _boolean(value: bool) -> str:  # noqa: FBT001 - it is the value that is spelled
    return "true" if value else "false"
