"""Devices that speak Homie 5, with the types of the smart-home profile of its libraries.

A device ``ID`` describes itself on ``homie/5/ID/$description`` and publishes its availability on ``$state``.
All its messages are retained. It takes commands on ``homie/5/ID/NODE/PROPERTY/set``.

Source: Homie convention 5.0; types of hc-smarthome v2.
"""

import re
from collections.abc import Callable, Mapping
from typing import TypeAlias

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.simulated_device import number_text
from homebot.house.wire import as_json, as_text, device_orders, hardware_address, mired_kelvin, scaled
from homebot.support.numbers import to_number

PROFILE = "hc-smarthome/v2/cap"


_FLAG = {"datatype": "boolean", "settable": True}
_WATCHED = {"datatype": "boolean"}
_PERCENT = {"datatype": "integer", "format": "0:100", "unit": "%", "settable": True}
_DIRECTION = {"datatype": "enum", "format": "up,down,stop", "settable": True, "retained": False}
_FLOOR = {"datatype": "enum", "settable": True}
_DOOR = {"datatype": "enum", "format": "open,closed,opening,closing", "settable": True}
_ACTIONS = {"up": "open", "down": "close", "stop": "stop", "lock": "lock", "unlock": "unlock"}
_DOOR_ORDERS = {"open": "open", "closed": "close"}
_TARGET = {"datatype": "float", "format": "5:30:0.5", "unit": "°C", "settable": True}
_WARMTH = {"datatype": "integer", "format": "112:666", "unit": "MK⁻¹", "settable": True}


_Row: TypeAlias = tuple[str, str, Mapping[str, object], Callable[[DeviceState], str] | None]
"""Node, property, its form, and its value in a state of the device; None for a property of commands alone."""


def _measured(unit: str) -> dict[str, object]:
    return {"datatype": "float", "unit": unit}


def _boolean(value: bool) -> str:  # noqa: FBT001 - it is the value that is spelled
    return "true" if value else "false"


_MOTOR: tuple[_Row, ...] = (
    ("shutter", "position", _PERCENT, lambda motor: number_text(motor.position * 100, 0)),
    ("shutter", "action", _DIRECTION, None),
)

ROWS: Mapping[str, tuple[_Row, ...]] = {
    "lamp": (
        ("switch", "state", _FLAG, lambda lamp: _boolean(lamp.is_on)),
        ("level", "value", _PERCENT, lambda lamp: number_text(lamp.brightness * 100, 0)),
        ("color", "color-temperature", _WARMTH, lambda lamp: number_text(1e6 / lamp.kelvin, 0)),
    ),
    "window": _MOTOR,
    "cover": _MOTOR,
    "lock": (("lock", "state", _FLAG, lambda lock: _boolean(lock.text == "locked")),),
    "lift": (
        ("lift", "floor", _FLOOR, lambda lift: lift.floor),
        ("lift", "door", _DOOR, lambda lift: lift.door),
    ),
    "contact": (("contact", "state", _WATCHED, lambda door: _boolean(door.text == "open")),),
    "motion": (("motion", "motion", _WATCHED, lambda room: _boolean(room.text == "motion")),),
    "lux": (("illuminance", "illuminance", _measured("lx"), lambda lux: number_text(lux.value)),),
    "power_meter": (("powermeter", "power", _measured("W"), lambda meter: number_text(meter.value)),),
    "thermostat": (
        ("thermostat", "set-temperature", _TARGET, lambda room: number_text(room.target)),
        ("climate", "temperature", _measured("°C"), lambda room: number_text(room.celsius, 1)),
    ),
}
"""By kind."""


class HomieDialect(Dialect):
    """Devices of the domain ``homie``: all kinds but robots."""

    kinds = frozenset(ROWS)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where its properties can be set."""
        return (f"{_base(device)}/+/+/set",)

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return its announcement, from init to ready; all retained."""
        base = _base(device)
        nodes: dict[str, dict[str, object]] = {}
        for node, _, _, _ in ROWS[device.kind]:
            properties = {prop: form for owner, prop, form, _ in ROWS[device.kind] if owner == node}
            nodes[node] = {"type": f"{PROFILE}/{node}", "properties": properties}
        if device.kind == "lift":  # of which the profile has none
            floors = ",".join(command for command in device.commands if command not in _DOOR_ORDERS.values())
            nodes["lift"] = {"type": "lift", "properties": {"floor": {**_FLOOR, "format": floors}, "door": _DOOR}}
        description = {"homie": "5.0", "version": 1, "name": device.device_id, "nodes": nodes}
        return (
            OutgoingMessage(f"{base}/$state", b"init", retain=True),
            OutgoingMessage(f"{base}/$description", as_json(description), retain=True),
            OutgoingMessage(f"{base}/$state", b"ready", retain=True),
        )

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        """Return that it is lost, kept."""
        return OutgoingMessage(f"{_base(device)}/$state", b"lost", retain=True)

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its properties, kept, each on its own topic."""
        base = _base(device)
        return tuple(
            OutgoingMessage(f"{base}/{node}/{prop}", value(state).encode(), retain=True)
            for node, prop, _, value in ROWS[device.kind]
            if value is not None
        )

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the command in the value of a property."""
        property_id, text = topic.split("/")[-2], as_text(payload)
        if device.kind == "lift":
            order = _DOOR_ORDERS.get(text) if property_id == "door" else text
            return (order,) if order in device.commands else ()
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


def _base(device: SimulatedDeviceInfo) -> str:
    name = f"{device.home}-{device.device_id}"
    plain = re.sub(r"[^a-z0-9-]", "-", name.lower())
    return f"homie/5/{plain if plain == name else f'{plain}-{hardware_address(device)[-6:]}'}"
