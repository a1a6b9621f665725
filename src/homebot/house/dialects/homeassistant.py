"""Devices that announce themselves by Home Assistant's MQTT discovery, as firmware like ESPHome does.

A device ``NODE`` says its whole state as JSON on ``NODE/state``, kept by the broker, hears on ``NODE/set`` and, for
a number of its own, ``NODE/set_position`` or ``NODE/set_temperature``, and says on ``NODE/status`` whether it is there.
Its announcement is one config of its component, or one of the whole device.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

from collections.abc import Sequence

from homebot.house.device_state import DeviceState
from homebot.house.dialect import Bridge, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.dialects.homeassistant_components import COMPONENTS
from homebot.house.dialects.wire import (
    as_json,
    as_object,
    as_text,
    cover_order,
    hardware_address,
    lamp_order,
    node_name,
)
from homebot.house.simulated_device import number_text
from homebot.numbers import to_number

__all__ = ["HomeAssistantDialect"]

MIRED = 1e6
LEVELS = 255


class HomeAssistantDialect:
    """Devices of Home Assistant's discovery.

    Args:
        whole_devices: Whether they announce themselves as whole devices, with abbreviated keys, rather than as single
            components.
        prefix: The discovery prefix.
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

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return its announcement, and that it is online; both kept."""
        node = node_name(device)
        config = self._whole(device) if self._whole_devices else self._single(device)
        return (config, OutgoingMessage(f"{node}/status", b"online", retain=True))

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        """Return that it is offline; kept."""
        return OutgoingMessage(f"{node_name(device)}/status", b"offline", retain=True)

    def state_messages(self, device: SimulatedDeviceInfo, condition: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its state, kept."""
        state = COMPONENTS[device.kind].state(condition)
        return (OutgoingMessage(f"{node_name(device)}/state", as_json(state), retain=True),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return what a command of Home Assistant's means."""
        text = as_text(payload)
        level = topic.rpartition("/")[2]
        if device.kind == "lamp":
            return _lamp_commands(payload)
        if device.kind == "lock":
            return (text.lower(),) if text in {"LOCK", "UNLOCK"} else ()
        value = to_number(text)
        if level == "set_position":
            return () if value is None else (number_text(value / 100),)
        if level == "set_temperature":
            return () if value is None else (number_text(value),)
        return cover_order(text) if device.kind in {"window", "cover"} else ()

    def replies(
        self, device: SimulatedDeviceInfo, condition: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return nothing: the broker keeps their state."""
        del device, condition, topic, payload
        return ()

    def bridge(self, devices: Sequence[SimulatedDeviceInfo]) -> Bridge | None:
        """Return None: each speaks for itself."""
        del devices
        return None

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


def _lamp_commands(payload: bytes) -> tuple[str, ...]:
    wanted = as_object(payload)
    brightness = to_number(wanted.get("brightness"))
    mireds = to_number(wanted.get("color_temp"))
    return lamp_order(
        is_on={"ON": True, "OFF": False}.get(str(wanted.get("state"))),
        brightness=None if brightness is None else brightness / LEVELS,
        kelvin=MIRED / mireds if mireds else None,
    )
