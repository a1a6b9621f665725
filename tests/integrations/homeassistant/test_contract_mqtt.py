"""The MQTT gateway keeps the contract, with a lamp of Home Assistant discovery on a broker in memory."""

import json
from collections.abc import Mapping
from typing import Any, ClassVar

import anyio

from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.testing.gateway_contract import Lamp, Neighbour
from homebot.testing.gateway_contract.mqtt import MqttContract, MqttLamp

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


class AnnouncedLamp(MqttLamp):
    """A lamp that announces itself as Home Assistant wants it."""

    settings: ClassVar[Mapping[str, PlainValue]] = {
        "level": 40.0,
        "color": (120.0, 80.0),
        "color_temperature": 2700.0,
        "effect": "fire",
    }
    together = LIGHT_CAPABILITIES

    def __init__(self, wire: MqttConnection, broker: MemoryBroker) -> None:
        super().__init__(wire, broker, "homeassistant:light/hall", "hall", address="hall/state")

    async def announce(self) -> None:
        await self.subscribe_commands("hall/set")
        await self.say("homeassistant/light/hall/config", json.dumps(CONFIG).encode(), retain=True)
        await self.say("hall/state", self.raw(on=False), retain=True)

    async def report(self, *, on: bool) -> None:
        await self.say("hall/state", self.raw(on=on))

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"state": "ON" if on else "OFF"}).encode()

    async def misbehave(self) -> None:
        for number in range(100):
            await self.say(f"homeassistant/light/stranger{number}/config", b"?" * 60_000)

    async def withdraw(self) -> None:
        await self.say("homeassistant/light/hall/config", b"", retain=True)

    async def told(self) -> bool | None:
        told = await self._told()
        return told.get("state") == "ON" if told else None

    async def told_value(self, capability: str) -> PlainValue:
        told = await self._told()
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

    async def _told(self) -> dict[str, Any]:
        await self.listen()
        told: dict[str, Any] = json.loads(self.orders[-1]) if self.orders else {}
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


class TestMqttGateway(MqttContract):
    """One lamp of Home Assistant discovery."""

    lamp_type = AnnouncedLamp
    table: ClassVar[Mapping[str, object]] = {"homeassistant": {"publish": True}}

    def neighbour(self, lamp: Lamp) -> Neighbour:
        assert isinstance(lamp, MqttLamp)
        return Onlooker(lamp.wire)
