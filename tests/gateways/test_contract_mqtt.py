"""The MQTT gateway keeps the contract, with a lamp of Home Assistant discovery on a broker in memory."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.gateways.contract import GatewayContract, Lamp, Neighbour

from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.hosted_broker import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

CONFIG = {"name": "Hall", "unique_id": "hall", "state_topic": "hall/state", "command_topic": "hall/set"}


class MqttLamp(Lamp):
    """A lamp that announces itself as Home Assistant wants it."""

    def __init__(self, wire: MqttConnection, broker: MemoryBroker) -> None:
        super().__init__("homeassistant:light/hall", "hall", address="hall/state")
        self.wire = wire
        self.broker = broker

    async def announce(self) -> None:
        await self.wire.wait_connected()
        await self.wire.subscribe(MqttSubscription("hall/set", qos=1))
        await self.wire.publish("homeassistant/light/hall/config", json.dumps(CONFIG).encode(), qos=1, retain=True)
        await self.wire.publish("hall/state", b"OFF", qos=1, retain=True)

    async def report(self, *, on: bool) -> None:
        await self.wire.publish("hall/state", self.raw(on=on), qos=1)

    def raw(self, *, on: bool) -> bytes:
        return b"ON" if on else b"OFF"

    async def misbehave(self) -> None:
        for number in range(100):
            await self.wire.publish(f"homeassistant/light/stranger{number}/config", b"?" * 60_000, qos=1)

    async def withdraw(self) -> None:
        await self.wire.publish("homeassistant/light/hall/config", b"", qos=1, retain=True)

    async def lose_link(self) -> None:
        await self.broker.stop(abrupt=True)

    async def mend_link(self) -> None:
        await self.broker.start()

    async def told(self) -> bool | None:
        told: bool | None = None
        with anyio.move_on_after(0.1):
            while True:
                batch = await self.wire.receive()
                self.wire.ack(batch)
                told = batch[-1].payload == b"ON"
        return told


class Onlooker(Neighbour):
    """A Home Assistant on the same broker."""

    def __init__(self, wire: MqttConnection) -> None:
        self._wire = wire
        self._topics: dict[str, bytes] = {}

    async def seen(self, name: str) -> bool | None:
        await self._look()
        fields = self._config(name)
        state = json.loads(self._topics.get(fields.get("state_topic", "")) or b"{}")
        return {"ON": True, "OFF": False}.get(state.get("state"))

    async def turn(self, name: str, *, on: bool) -> None:
        command = json.dumps({"state": "ON" if on else "OFF"})
        await self._wire.publish(self._config(name)["command_topic"], command.encode(), qos=1)

    async def _look(self) -> None:
        await self._wire.subscribe(MqttSubscription("homeassistant/#"), MqttSubscription("homebot/#"))
        with anyio.move_on_after(0.1):
            while True:
                batch = await self._wire.receive()
                self._wire.ack(batch)
                self._topics |= {one.topic: one.payload for one in batch}

    def _config(self, name: str) -> dict[str, str]:
        configs = [json.loads(one) for topic, one in self._topics.items() if topic.endswith("/config") and one]
        return next((one for one in configs if one.get("device", {}).get("name") == name), {})


@pytest.mark.virtual_time
class TestMqttGateway(GatewayContract):
    """One lamp of Home Assistant discovery."""

    name = "mqtt"
    time_is_virtual = True

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with (
            MemoryBroker() as broker,
            MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as wire,
        ):
            await wire.wait_connected()
            yield MqttLamp(wire, broker)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, MqttLamp)
        table = {"url": lamp.broker.url, "act": True, "homeassistant": {"publish": True}, **settings}
        context = GatewayContext.of(HostedBroker.in_memory(lamp.broker))
        return MqttGateway(node, MqttGatewaySettings.model_validate(table), context)

    def neighbour(self, lamp: Lamp) -> Neighbour:
        assert isinstance(lamp, MqttLamp)
        return Onlooker(lamp.wire)
