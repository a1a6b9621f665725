"""Devices that speak Homie 5, with the types of the smart-home profile of its libraries.

A device ``ID`` describes itself on ``homie/5/ID/$description`` and says on ``$state`` whether it is there. The broker
keeps all that it says. It hears on ``homie/5/ID/NODE/PROPERTY/set``.

Source: Homie convention 5.0; types of hc-smarthome v2.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from homebot.house.device_state import DeviceState
from homebot.house.dialect import Bridge, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.dialects.homie_nodes import NODES
from homebot.house.dialects.wire import as_json, as_text, hardware_address, lamp_order
from homebot.house.simulated_device import number_text
from homebot.numbers import to_number

__all__ = ["HomieDialect"]

MIRED = 1e6


class HomieDialect:
    """Devices of one Homie domain.

    Args:
        domain: First level of their topics.
    """

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
        """Return how it begins, what it is, and that it is ready; all kept."""
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

    def state_messages(self, device: SimulatedDeviceInfo, condition: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its properties, kept, each on its own topic."""
        base = self._base(device)
        return tuple(
            OutgoingMessage(f"{base}/{name}/{key}", value.encode(), retain=True)
            for name, node in NODES[device.kind].items()
            for key, value in node.values(condition).items()
        )

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return what the value of a property means."""
        property_id, text = topic.split("/")[-2], as_text(payload)
        wanted = to_number(text)
        if property_id == "action":
            return _action(device.kind, text)
        if property_id == "state":
            return _state(device.kind, text)
        if wanted is None:
            return ()
        if property_id == "color-temperature":
            return lamp_order(kelvin=MIRED / wanted) if wanted else ()
        if property_id == "value":
            return lamp_order(brightness=wanted / 100) if device.kind == "lamp" else ()
        return {"position": (number_text(wanted / 100),), "set-temperature": (number_text(wanted),)}.get(
            property_id, ()
        )

    def replies(
        self, device: SimulatedDeviceInfo, condition: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return nothing: the broker keeps all they say."""
        del device, condition, topic, payload
        return ()

    def bridge(self, devices: Sequence[SimulatedDeviceInfo]) -> Bridge | None:
        """Return None: each speaks for itself."""
        del devices
        return None

    def _base(self, device: SimulatedDeviceInfo) -> str:
        return f"{self._domain}/5/{_id(device)}"


def _id(device: SimulatedDeviceInfo) -> str:
    """A Homie id: lower-case letters, digits and ``-``."""
    name = f"{device.home}-{device.device_id}"
    plain = re.sub(r"[^a-z0-9-]", "-", name.lower())
    return plain if plain == name else f"{plain}-{hardware_address(device)[-6:]}"


def _state(kind: str, text: str) -> tuple[str, ...]:
    wanted = {"true": True, "false": False}.get(text)
    if wanted is None:
        return ()
    if kind == "lock":
        return ("lock" if wanted else "unlock",)
    return lamp_order(is_on=wanted) if kind == "lamp" else ()


def _action(kind: str, text: str) -> tuple[str, ...]:
    if kind in {"window", "cover"}:
        return {"up": ("open",), "down": ("close",), "stop": ("stop",)}.get(text, ())
    return (text,) if kind == "lock" and text in {"lock", "unlock"} else ()
