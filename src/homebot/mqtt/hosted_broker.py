"""A broker that runs in this process, as its clients see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from homebot.mqtt.client import MqttClient
from homebot.mqtt.options import MqttOptions

if TYPE_CHECKING:
    from homebot.mqtt.memory_broker import MemoryBroker

__all__ = ["HostedBroker"]


@dataclass(frozen=True, slots=True, eq=False)
class HostedBroker:
    """A broker that runs in this process.

    Attributes:
        url: Its address, as ``mqtt://host:port``.
        make_client: Makes the clients that reach it; None where any client does, because it listens on a socket.
        computer: The name of the computer in topics of status; empty for the one that the system gives.
    """

    url: str
    make_client: Callable[[MqttOptions], MqttClient] | None = None
    computer: str = ""

    @classmethod
    def in_memory(cls, broker: MemoryBroker) -> HostedBroker:
        """Return *broker* as such, which is reached without a socket."""
        return cls(broker.url, broker.make_client, broker.host)
