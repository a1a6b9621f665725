"""The contract for devices on MQTT: a convention's lamp, on a broker in memory that can go away."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import ClassVar

import anyio
import pytest

from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.testing.gateway_contract import GatewayContract, Lamp
from homebot.testing.pytest_loops import VIRTUAL_TIME


class MqttLamp(Lamp):
    """A lamp that is an MQTT client of its own.

    Attributes:
        wire: Its connection.
        orders: The payloads that it received, in order; see :meth:`listen`.
    """

    def __init__(self, wire: MqttConnection, broker: MemoryBroker, key: str, part: str = "", *, address: str) -> None:
        super().__init__(key, part, address=address)
        self.wire = wire
        self.broker = broker
        self.orders: list[bytes] = []

    async def subscribe_commands(self, topic: str) -> None:
        """Subscribe to *topic*."""
        await self.wire.wait_connected()
        await self.wire.subscribe(MqttSubscription(topic, qos=1))

    async def say(self, topic: str, payload: bytes, *, retain: bool = False) -> None:
        """Publish *payload*."""
        await self.wire.publish(topic, payload, qos=1, retain=retain)

    async def listen(self) -> None:
        """Receive the commands that are under way."""
        with anyio.move_on_after(0.1):
            while True:
                batch = await self.wire.receive()
                self.wire.ack(batch)
                self.orders += [message.payload for message in batch]

    async def lose_link(self) -> None:
        """Stop the broker."""
        await self.broker.stop(abrupt=True)

    async def mend_link(self) -> None:
        """Start it again."""
        await self.broker.start()


@pytest.mark.usefixtures(VIRTUAL_TIME)
class MqttContract(GatewayContract):
    """The contract of the MQTT gateway, with one lamp.

    Attributes:
        lamp_type: The class of the lamp, made of its connection and the broker.
        table: The table of the gateway, such as ``{"conventions": ["acme"]}``.
    """

    name = "mqtt"
    time_is_virtual = True
    lamp_type: ClassVar[type[MqttLamp]]
    table: ClassVar[Mapping[str, object]]

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        """Yield the lamp, connected."""
        async with (
            MemoryBroker() as broker,
            MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as wire,
        ):
            await wire.wait_connected()
            make: type = self.lamp_type  # which gives the key and the address itself
            yield make(wire, broker)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        """Return the MQTT gateway on its broker."""
        assert isinstance(lamp, MqttLamp)
        table = {"url": lamp.broker.url, "act": True, **self.table, **settings}
        context = GatewayContext.of(HostedBroker.in_memory(lamp.broker))
        return MqttGateway(node, MqttGatewaySettings.model_validate(table), context)
