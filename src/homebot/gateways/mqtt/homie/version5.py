"""Devices of Homie 5, each of which says its state and describes itself in one document. Pure.

A device exists once both are known and it is not starting; a new document counts when it is ready again.

Source: Homie convention 5, Device Lifecycle and $description.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.errors import WireError
from homebot.gateways.mqtt.bounded import Bounded
from homebot.gateways.mqtt.description import Heard, Withdrawn
from homebot.gateways.mqtt.homie.described import describe
from homebot.gateways.mqtt.homie.document import is_id, parse_document
from homebot.gateways.mqtt.homie.model import HomieDevice
from homebot.gateways.mqtt.homie.state import STATES
from homebot.gateways.mqtt.payload import shown

__all__ = ["FILTERS", "Version5"]

FILTERS = ("{domain}/5/+/$description", "{domain}/5/+/$state")
"""The documents first, so that all is there when the state says ready."""

_MAX_DEVICES = 5000


@dataclass(slots=True)
class _Device:
    state: str = ""
    document: HomieDevice | None = None
    payload: int = 0
    is_new: bool = False
    is_described: bool = False


class Version5:
    """Knows the devices of version 5.

    There is room for 5,000: of more, the one that was heard first and never described is forgotten.

    Attributes:
        ignored: Nodes and properties that were illegal, so far.
    """

    def __init__(self) -> None:
        self.ignored = 0
        self._devices: Bounded[_Device] = Bounded(_MAX_DEVICES)

    @property
    def dropped(self) -> int:
        """How many devices were forgotten or not taken for want of room."""
        return self._devices.dropped

    def take(self, domain: str, device_id: str, attribute: str, payload: bytes) -> tuple[Heard, ...]:
        """Take an attribute of a device.

        Raises:
            WireError: It is illegal.
        """
        if not is_id(device_id):
            raise WireError(f"{shown(device_id)} is no id of a device")
        name = f"{domain}/5/{device_id}"
        if not payload:
            return self._removed(name, attribute)
        device = self._devices.get(name)
        if device is None:
            device = _Device()
            if not self._devices.add(name, device):
                return ()
        if attribute == "$state":
            state = payload.decode(errors="replace") if len(payload) <= len("disconnected") else ""
            if state not in STATES:
                raise WireError(f"$state is {shown(payload)}")
            device.state = state
        else:
            self._describe_itself(device, domain, device_id, payload)
        return self._heard(device, name, domain)

    def _describe_itself(self, device: _Device, domain: str, device_id: str, payload: bytes) -> None:
        said = hash(payload)
        if device.document is not None and device.payload == said:
            return
        document = parse_document(domain, device_id, payload)
        self.ignored += document.ignored
        device.payload, device.document, device.is_new = said, document.device, True

    def _heard(self, device: _Device, name: str, domain: str) -> tuple[Heard, ...]:
        if device.document is None or not device.is_new or device.state in {"", "init"}:
            return ()
        device.is_new = False
        described = describe(device.document, domain, is_alive=bool(STATES[device.state]))
        if described is None:
            was_described, device.is_described = device.is_described, False
            return (Withdrawn(name, "it offers nothing any more"),) if was_described else ()
        self._devices.keep(name)
        device.is_described = True
        return (described,)

    def _removed(self, name: str, attribute: str) -> tuple[Heard, ...]:
        device = self._devices.get(name)
        if device is None:
            return ()
        if attribute == "$state":
            self._devices.remove(name)
            return (Withdrawn(name, "its state was removed", is_final=True),) if device.is_described else ()
        device.document, device.is_new = None, False
        was_described, device.is_described = device.is_described, False
        return (Withdrawn(name, "its description was removed"),) if was_described else ()
