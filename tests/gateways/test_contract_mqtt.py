"""The MQTT gateway keeps the contract, with a lamp of Home Assistant discovery on a broker in memory."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.gateways.contract import GatewayContract, Lamp, running

from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.hosted_broker import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

CONFIG = {"name": "Hall", "unique_id": "hall", "state_topic": "hall/state", "command_topic": "hall/set"}


class MqttLamp(Lamp):
    """A lamp that announces itself as Home Assistant wants it."""

    def __init__(self, gateway: MqttGateway, wire: MqttConnection, broker: MemoryBroker) -> None:
        super().__init__(gateway, "homeassistant:light/hall", "hall")
        self._wire = wire
        self._broker = broker

    async def announce(self) -> None:
        await self._wire.subscribe(MqttSubscription("hall/set", qos=1))
        await self._wire.publish("homeassistant/light/hall/config", json.dumps(CONFIG).encode(), qos=1, retain=True)
        await self._wire.publish("hall/state", b"OFF", qos=1, retain=True)

    async def report(self, *, on: bool) -> None:
        await self._wire.publish("hall/state", b"ON" if on else b"OFF", qos=1)

    async def withdraw(self) -> None:
        await self._wire.publish("homeassistant/light/hall/config", b"", qos=1, retain=True)

    async def lose_link(self) -> None:
        await self._broker.stop(abrupt=True)

    async def mend_link(self) -> None:
        await self._broker.start()

    async def told(self) -> bool | None:
        told: bool | None = None
        with anyio.move_on_after(0.1):
            while True:
                batch = await self._wire.receive()
                self._wire.ack(batch)
                told = batch[-1].payload == b"ON"
        return told


@pytest.mark.virtual_time
class TestMqttGateway(GatewayContract):
    """One lamp of Home Assistant discovery."""

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with (
            MemoryBroker() as broker,
            Node(Graph(), "mqtt", namespace="/gateway") as node,
            MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as wire,
        ):
            await wire.wait_connected()
            context = GatewayContext.of(HostedBroker.in_memory(broker))
            gateway = MqttGateway(node, MqttGatewaySettings(url=broker.url, act=True), context)
            async with running(gateway):
                yield MqttLamp(gateway, wire, broker)
