"""The MQTT gateway keeps the contract, with a lamp of Home Assistant discovery on a broker in memory."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any, ClassVar

import anyio
import pytest

from homebot.devices.value import PlainValue
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.testing.gateway_contract import GatewayContract, Lamp, Neighbour

CONFIG = {
    "name": "Hall",
    "unique_id": "hall",
    "schema": "json",
    "state_topic": "hall/state",
    "command_topic": "hall/set",
    "brightness": True,
    "color_temp_kelvin": True,
    "supported_color_modes": ["color_temp", "hs"],
    "effect": True,
    "effect_list": ["fire", "none"],
}


class MqttLamp(Lamp):
    """A lamp that announces itself as Home Assistant wants it."""

    settings: ClassVar[Mapping[str, PlainValue]] = {
        "level": 40.0,
        "color": (120.0, 80.0),
        "color_temperature": 2700.0,
        "effect": "fire",
    }

    def __init__(self, wire: MqttConnection, broker: MemoryBroker) -> None:
        super().__init__("homeassistant:light/hall", "hall", address="hall/state")
        self.wire = wire
        self.broker = broker
        self._orders: list[dict[str, Any]] = []

    async def announce(self) -> None:
        await self.wire.wait_connected()
        await self.wire.subscribe(MqttSubscription("hall/set", qos=1))
        await self.wire.publish("homeassistant/light/hall/config", json.dumps(CONFIG).encode(), qos=1, retain=True)
        await self.wire.publish("hall/state", self.raw(on=False), qos=1, retain=True)

    async def report(self, *, on: bool) -> None:
        await self.wire.publish("hall/state", self.raw(on=on), qos=1)

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"state": "ON" if on else "OFF"}).encode()

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
        await self._listen()
        return self._orders[-1].get("state") == "ON" if self._orders else None

    async def told_value(self, capability: str) -> PlainValue:
        await self._listen()
        told = self._orders[-1] if self._orders else {}
        match capability:
            case "level" if "brightness" in told:
                return float(told["brightness"] * 100 / 255)
            case "color" if "color" in told:
                return float(told["color"]["h"]), float(told["color"]["s"])
            case "color_temperature" if "color_temp" in told:
                return float(told["color_temp"])
            case "effect":
                return str(told.get("effect", ""))
        return None

    async def _listen(self) -> None:
        with anyio.move_on_after(0.1):
            while True:
                batch = await self.wire.receive()
                self.wire.ack(batch)
                self._orders += [json.loads(one.payload) for one in batch]


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
