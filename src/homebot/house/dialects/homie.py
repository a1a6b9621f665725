"""Devices that speak Homie 5, with the types of the smart-home profile of its libraries.

A device ``ID`` describes itself on ``homie/5/ID/$description`` and publishes its availability on ``$state``.
All its messages are retained. It takes commands on ``homie/5/ID/NODE/PROPERTY/set``.

Source: Homie convention 5.0; types of hc-smarthome v2.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.dialects.wire import as_json, as_text, device_orders, hardware_address, mired_kelvin, scaled
from homebot.house.simulated_device import number_text
from homebot.support.numbers import to_number

__all__ = ["NODES", "HomieDialect", "SimulatedHomieNode"]

PROFILE = "hc-smarthome/v2/cap"


@dataclass(frozen=True, slots=True)
class SimulatedHomieNode:
    """A node.

    Attributes:
        values: Returns the values that a device in some state publishes.
    """

    type: str
    properties: Mapping[str, Mapping[str, object]]
    values: Callable[[DeviceState], Mapping[str, str]]

    def description(self) -> dict[str, object]:
        """Return it as the device's description has it."""
        return {"type": f"{PROFILE}/{self.type}", "properties": dict(self.properties)}


_FLAG = {"datatype": "boolean", "settable": True}
_PERCENT = {"datatype": "integer", "format": "0:100", "unit": "%", "settable": True}
_DIRECTION = {"datatype": "enum", "format": "up,down,stop", "settable": True, "retained": False}
_ACTIONS = {"up": "open", "down": "close", "stop": "stop", "lock": "lock", "unlock": "unlock"}
_TARGET = {"datatype": "float", "format": "5:30:0.5", "unit": "°C", "settable": True}
_WARMTH = {"datatype": "integer", "format": "112:666", "unit": "MK⁻¹", "settable": True}


def _boolean(value: bool) -> str:  # noqa: FBT001 - it is the value that is spelled
    return "true" if value else "false"


def _node(
    name: str,
    prop: str,
    form: Mapping[str, object],
    value: Callable[[DeviceState], str],
    **others: Mapping[str, object],
) -> dict[str, SimulatedHomieNode]:
    """Return a node with one value, and with *others*, properties that have none; its type is its name."""
    return {name: SimulatedHomieNode(name, {prop: form, **others}, lambda state: {prop: value(state)})}


_MOTOR = _node("shutter", "position", _PERCENT, lambda motor: number_text(motor.position * 100, 0), action=_DIRECTION)

NODES: Mapping[str, Mapping[str, SimulatedHomieNode]] = MappingProxyType(
    {
        "lamp": {
            **_node("switch", "state", _FLAG, lambda lamp: _boolean(lamp.is_on)),
            **_node("level", "value", _PERCENT, lambda lamp: number_text(lamp.brightness * 100, 0)),
            **_node("color", "color-temperature", _WARMTH, lambda lamp: number_text(1e6 / lamp.kelvin, 0)),
        },
        "window": _MOTOR,
        "cover": _MOTOR,
        "lock": _node("lock", "state", _FLAG, lambda lock: _boolean(lock.text == "locked")),
        "contact": _node("contact", "state", {"datatype": "boolean"}, lambda door: _boolean(door.text == "open")),
        "motion": _node("motion", "motion", {"datatype": "boolean"}, lambda room: _boolean(room.text == "motion")),
        "lux": _node(
            "illuminance", "illuminance", {"datatype": "float", "unit": "lx"}, lambda lux: number_text(lux.value)
        ),
        "power_meter": _node(
            "powermeter", "power", {"datatype": "float", "unit": "W"}, lambda meter: number_text(meter.value)
        ),
        "thermostat": {
            **_node("thermostat", "set-temperature", _TARGET, lambda room: number_text(room.target)),
            **_node(
                "climate",
                "temperature",
                {"datatype": "float", "unit": "°C"},
                lambda room: number_text(room.celsius, 1),
            ),
        },
    }
)
"""By kind and by the node's id."""


class HomieDialect(Dialect):
    """Devices of one Homie domain."""

    def __init__(self, domain: str = "homie") -> None:
        self._domain = domain

    @property
    def kinds(self) -> frozenset[str]:
        """All but robots."""
        return frozenset(NODES)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where its properties can be set."""
        return (f"{self._base(device)}/+/+/set",)

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return its announcement, from init to ready; all retained."""
        base = self._base(device)
        nodes = {name: node.description() for name, node in NODES[device.kind].items()}
        description = {"homie": "5.0", "version": 1, "name": device.device_id, "nodes": nodes}
        return (
            OutgoingMessage(f"{base}/$state", b"init", retain=True),
            OutgoingMessage(f"{base}/$description", as_json(description), retain=True),
            OutgoingMessage(f"{base}/$state", b"ready", retain=True),
        )

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        """Return that it is lost, kept."""
        return OutgoingMessage(f"{self._base(device)}/$state", b"lost", retain=True)

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its properties, kept, each on its own topic."""
        base = self._base(device)
        return tuple(
            OutgoingMessage(f"{base}/{name}/{key}", value.encode(), retain=True)
            for name, node in NODES[device.kind].items()
            for key, value in node.values(state).items()
        )

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the command in the value of a property."""
        property_id, text = topic.split("/")[-2], as_text(payload)
        flag = {"true": True, "false": False}.get(text) if property_id == "state" else None
        action = _ACTIONS.get(text, "") if property_id == "action" else ""
        return device_orders(
            device.kind,
            is_on=flag,
            brightness=scaled(text, 100) if property_id == "value" else None,
            kelvin=mired_kelvin(text) if property_id == "color-temperature" else None,
            position=scaled(text, 100) if property_id == "position" else None,
            action=action if flag is None else "lock" if flag else "unlock",
            target=to_number(text) if property_id == "set-temperature" else None,
        )

    def _base(self, device: SimulatedDeviceInfo) -> str:
        return f"{self._domain}/5/{_id(device)}"


def _id(device: SimulatedDeviceInfo) -> str:
    name = f"{device.home}-{device.device_id}"
    plain = re.sub(r"[^a-z0-9-]", "-", name.lower())
    return plain if plain == name else f"{plain}-{hardware_address(device)[-6:]}"
