"""Clients by their names in a configuration, and a broker in this process as its clients see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from homebot.mqtt.client import MqttClient
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.options import MqttOptions

if TYPE_CHECKING:
    from homebot.mqtt.memory_broker import MemoryBroker

__all__ = ["HostedBroker", "MqttClientName", "client_maker"]

MqttClientName: TypeAlias = Literal["aiomqtt", "native"]


def client_maker(name: MqttClientName) -> Callable[[MqttOptions], MqttClient]:
    """Return the factory for clients of this name."""
    if name == "native":
        return NativeClient
    from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient  # noqa: PLC0415 - its libraries take long to import

    return AiomqttClient


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
