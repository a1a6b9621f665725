"""MQTT clients by their names in the configuration, and a broker in this process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from homebot.mqtt.client import MqttClient
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.options import MqttOptions

if TYPE_CHECKING:
    from homebot.mqtt.memory_broker import MemoryBroker

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
        make_client: Makes clients that reach it; None if it listens on a socket, so that any client does.
        computer: The computer's name in status topics; empty for the name given by the system.
    """

    url: str
    make_client: Callable[[MqttOptions], MqttClient] | None = None
    computer: str = ""

    @classmethod
    def in_memory(cls, broker: MemoryBroker) -> HostedBroker:
        """Return the *broker* as a hosted one, reached without a socket."""
        return cls(broker.url, broker.make_client, broker.host)
