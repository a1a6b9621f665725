"""Port of pure functions between a device and MQTT, one for each family of devices.

A word is what a device of :mod:`homebot.house` says or is told, such as ``on`` or ``21.5``. What goes over the
wire is the dialect's own. A device that another speaks for, as a bridge for its lamps, says everything itself here;
only what the bridge says of itself and of all its devices is said by one client more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from homebot.errors import UsageError
from homebot.house.device_state import DeviceState

__all__ = ["Bridge", "Dialect", "OutgoingMessage", "SimulatedDeviceInfo"]


@dataclass(frozen=True, slots=True)
class SimulatedDeviceInfo:
    """The identity of a simulated device.

    Attributes:
        home: First level, or levels, of the topics.
        kind: What it is, as houses are described: ``lamp``.
        device_id: Its name.
        service_type: What it offers.
        room: Where it is.

    Raises:
        UsageError: The name or the service type is empty or cannot be one level of a topic.
    """

    home: str
    kind: str
    device_id: str
    service_type: str
    room: str

    def __post_init__(self) -> None:
        for level in (self.device_id, self.service_type):
            if not level or any(character in level for character in "/+#\0"):
                raise UsageError(f"{level!r} cannot be a level of a topic, as a device's name and service type must")


@dataclass(frozen=True, slots=True)
class OutgoingMessage:
    """A message that a device sends.

    Attributes:
        topic: Where to.
        payload: What.
        retain: Whether the broker keeps it for those who come later.
        qos: How sure it has to be that it comes, 0 to 2.
    """

    topic: str
    payload: bytes
    retain: bool = False
    qos: int = 1


@dataclass(frozen=True, slots=True)
class Bridge:
    """The one program that speaks for all devices that are bound to it.

    Attributes:
        birth: On each new link.
        will: When it vanishes.
    """

    birth: tuple[OutgoingMessage, ...]
    will: OutgoingMessage


class Dialect(Protocol):
    """A family of devices. No function raises, whatever conditions and payloads it is given."""

    @property
    def kinds(self) -> frozenset[str]:
        """The kinds of devices, as houses are described, that there are in this family."""
        ...

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return the topic filters that *device* subscribes to."""
        ...

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return what *device* says first on each new link, before its state: announcement, availability."""
        ...

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage | None:
        """Return what the broker says when *device* vanishes."""
        ...

    def state_messages(self, device: SimulatedDeviceInfo, condition: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return the messages by which *device* says its last word, with the state that its family says with it."""
        ...

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the commands in a message that came in; empty where it holds none."""
        ...

    def replies(
        self, device: SimulatedDeviceInfo, condition: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return what *device* says because a message that came in asks for it; empty where it asks nothing."""
        ...

    def bridge(self, devices: Sequence[SimulatedDeviceInfo]) -> Bridge | None:
        """Return the bridge that *devices*, all of this family in a house, are bound to; None where there is none."""
        ...
