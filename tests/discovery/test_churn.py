"""A house in which everything changes all the time, and an oracle who knows what is truly there.

Lamps come, go, die without a word, come back, get other names, announce themselves twice and by two conventions, share
names, and take the place of others; the broker starts anew, with what it kept and without. ``CHURN`` in the
environment is the number of seeds.
"""

import json
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from random import Random
from typing import Literal, TypeAlias

import anyio
import pytest
from tests.sizes import size

from homebot.clock import LoopClock
from homebot.devices import Device
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.slow

EVENTS = size(2_020, 10_100)
LOOKS = 40
SEEDS = int(os.environ.get("CHURN", "1"))

STALE_AFTER = 600.0
FORGET_AFTER = 3600.0
ONLINE_FOR = 86_400.0
"""Seconds of silence that a device may have which said that it is online: its last will watches over it."""
GRACE = 11.0
"""Seconds after which a taken-back announcement counts."""

CONVENTIONS = ("homeassistant", "homebot.integrations.zigbee2mqtt.formats:Zigbee2Mqtt")
NAMES = [
    f"{room} {thing}" for room in ("Kitchen", "Küche", "hall", "0x00158d00000000ff") for thing in ("lamp", "light")
]
EXPOSES = [
    {
        "type": "light",
        "features": [
            {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"},
            {"type": "numeric", "name": "brightness", "property": "brightness", "access": 7, "value_max": 254},
        ],
    }
]

Kind: TypeAlias = Literal["firmware", "zigbee", "both"]
"""How a lamp is announced: by itself, by its bridge's own list, or by that and to Home Assistant too."""


@dataclass(eq=False)
class Lamp:
    """What is truly there.

    Attributes:
        number: Makes its hardware address.
        kind: How it is announced.
        watches: Whether its availability is told.
        name: What people call it.
        is_listed: Whether it is announced.
        is_alive: Whether it has power.
        is_on: What it said last.
        has_spoken: Whether it spoke since its topics are as they are.
        sign: When it last gave a sign of life.
        gap: The longest time between two signs.
        device_id: Its id in the directory; empty before it was found there.
    """

    number: int
    kind: Kind
    watches: bool
    name: str = ""
    is_listed: bool = False
    is_alive: bool = False
    is_on: bool = False
    has_spoken: bool = False
    sign: float = 0.0
    gap: float = 0.0
    device_id: str = ""

    @property
    def ieee(self) -> str:
        return f"0x00158d{self.number:010x}"

    @property
    def mac(self) -> str:
        return f"24:0a:c4:{self.number // 65536 % 256:02x}:{self.number // 256 % 256:02x}:{self.number % 256:02x}"

    @property
    def identifier(self) -> str:
        return f"mac:{self.mac.replace(':', '')}" if self.kind == "firmware" else f"eui64:{self.ieee[2:]}"

    @property
    def topic(self) -> str:
        return f"esp-{self.number}/light" if self.kind == "firmware" else f"zigbee2mqtt/{self.name}"

    def availability(self) -> tuple[str, bool]:
        """Where it is told whether it is there, and whether in JSON."""
        return (f"esp-{self.number}/status", False) if self.kind == "firmware" else (f"{self.topic}/availability", True)

    def lives(self, now: float) -> None:
        """Note a sign of life."""
        self.gap = max(self.gap, now - self.sign if self.sign else 0.0)
        self.sign = now

    def time_to_live(self) -> float:
        """After how many silent seconds it must be gone, at the latest."""
        return max(STALE_AFTER, 3.0 * self.gap, ONLINE_FOR if self.watches else 0.0) + FORGET_AFTER


@dataclass
class Churn:
    """What happens, and what must then be known."""

    broker: MemoryBroker
    directory: Directory
    gateway: MqttGateway
    wire: MqttConnection
    clock: LoopClock
    dice: Random
    lamps: list[Lamp] = field(default_factory=list)
    deaths: int = 0

    async def say(self, topic: str, payload: object, *, retain: bool = False) -> None:
        words = payload if isinstance(payload, str) else json.dumps(payload)
        await self.wire.publish(topic, words.encode(), retain=retain)

    def some(self, wanted: Callable[[Lamp], bool]) -> Lamp | None:
        found = [lamp for lamp in self.lamps if wanted(lamp)]
        return self.dice.choice(found) if found else None

    def free_name(self, kind: Kind) -> str:
        """A name that others may have, too; behind a bridge each is there once, but one who went may have had it."""
        name = self.dice.choice(NAMES)
        taken = {lamp.name for lamp in self.lamps if lamp.is_listed and lamp.kind != "firmware"}
        number = 2
        while kind != "firmware" and name in taken:
            name, number = f"{name.rstrip('0123456789 ')} {number}", number + 1
        return name

    async def list_zigbee(self) -> None:
        listed = [
            {
                "ieee_address": lamp.ieee,
                "type": "Router",
                "friendly_name": lamp.name,
                "supported": True,
                "interview_state": "SUCCESSFUL",
                "definition": {"model": "LED2003G10", "vendor": "IKEA", "description": "a lamp", "exposes": EXPOSES},
            }
            for lamp in self.lamps
            if lamp.is_listed and lamp.kind != "firmware"
        ]
        await self.say("zigbee2mqtt/bridge/devices", listed, retain=True)

    async def announce(self, lamp: Lamp) -> None:
        if lamp.kind != "firmware":
            await self.list_zigbee()
        if lamp.kind != "zigbee":
            await self.say(_config_topic(lamp), _config(lamp), retain=True)

    async def tell_presence(self, lamp: Lamp, word: str) -> None:
        topic, is_json = lamp.availability()
        if lamp.watches:
            await self.say(topic, {"state": word} if is_json else word, retain=True)

    async def report(self, lamp: Lamp | None) -> None:
        if lamp is None:
            return
        lamp.is_on = self.dice.random() < 0.5
        lamp.has_spoken = True
        lamp.lives(self.clock.now())
        await self.say(lamp.topic, {"state": "ON" if lamp.is_on else "OFF", "brightness": 100})

    async def join(self) -> None:
        """A new lamp, or one that left before."""
        lamp = self.some(lambda one: not one.is_listed) if self.dice.random() < 0.4 else None
        if lamp is None:
            kind: Kind = self.dice.choice(("firmware", "zigbee", "both"))
            lamp = Lamp(len(self.lamps) + 1, kind, watches=self.dice.random() < 0.3)
            self.lamps.append(lamp)
        lamp.name = self.free_name(lamp.kind)
        lamp.is_listed = lamp.is_alive = True
        lamp.has_spoken = False
        lamp.lives(self.clock.now())
        await self.announce(lamp)
        await anyio.sleep(1.0)  # it is subscribed to
        await self.tell_presence(lamp, "online")
        await self.report(lamp)

    async def leave(self) -> None:
        """Somebody takes it out of the house, dead or alive."""
        lamp = self.some(lambda one: one.is_listed)
        if lamp is None:
            return
        lamp.is_listed = lamp.is_alive = False
        if lamp.kind != "firmware":
            await self.list_zigbee()
        if lamp.kind != "zigbee":
            await self.say(_config_topic(lamp), "", retain=True)

    async def die(self) -> None:
        """It falls silent; its announcements stay."""
        lamp = self.some(lambda one: one.is_alive)
        if lamp is not None:
            lamp.is_alive = False
            self.deaths += 1
            await self.tell_presence(lamp, "offline")

    async def revive(self) -> None:
        lamp = self.some(lambda one: one.is_listed and not one.is_alive)
        if lamp is not None:
            lamp.is_alive = True
            await self.announce(lamp)
            await self.tell_presence(lamp, "online")
            await self.report(lamp)

    async def rename(self) -> None:
        lamp = self.some(lambda one: one.is_alive)
        if lamp is None:
            return
        lamp.has_spoken = lamp.kind == "firmware" and lamp.has_spoken
        if lamp.kind == "both":  # as the bridge does: it clears its configs, and publishes new ones
            await self.say(_config_topic(lamp), "", retain=True)
            await anyio.sleep(2.0)
        lamp.name = self.free_name(lamp.kind)
        await self.announce(lamp)
        await self.tell_presence(lamp, "online")

    async def repeat(self) -> None:
        lamp = self.some(lambda one: one.is_alive)
        if lamp is not None:
            await self.announce(lamp)

    async def restart(self) -> None:
        """The broker goes down; one that loses everything hears all announcements again, also of the dead."""
        keeps = self.dice.random() < 0.7
        await self.broker.restart(keep_sessions=keeps, abrupt=self.dice.random() < 0.5)
        await anyio.sleep(60.0)
        await self.wire.wait_connected()
        if not keeps:
            await self.say("zigbee2mqtt/bridge/state", {"state": "online"}, retain=True)
            await self.list_zigbee()
            for lamp in self.lamps:
                if lamp.is_listed and lamp.kind != "zigbee":
                    await self.say(_config_topic(lamp), _config(lamp), retain=True)
            for lamp in self.lamps:
                if lamp.is_alive:
                    await self.tell_presence(lamp, "online")

    async def cut(self) -> None:
        self.broker.links[0].abort()
        await anyio.sleep(60.0)
        await self.wire.wait_connected()

    async def step(self) -> None:
        """One thing happens, a while after the last."""
        await anyio.sleep(self.dice.expovariate(1 / 5.0))
        chance = self.dice.random()
        for share, event in (
            (0.014, self.join),
            (0.016, self.leave),
            (0.012, self.die),
            (0.007, self.revive),
            (0.020, self.rename),
            (0.020, self.repeat),
            (0.001, self.restart),
            (0.001, self.cut),
        ):
            if chance < share:
                await event()
                return
            chance -= share
        await self.report(self.some(lambda one: one.is_alive))

    async def look(self) -> None:
        """Compare what is known with what is."""
        await anyio.sleep(GRACE)
        truth = {lamp.identifier: lamp for lamp in self.lamps if lamp.is_listed}
        known: dict[str, Device] = {}
        for device in self.directory.index.devices():
            (hardware,) = [
                one for one in device.identifiers if not one.startswith("id:")
            ]  # no two lamps are one device
            assert hardware not in known, f"{device.id} and {known[hardware].id} are one lamp"
            known[hardware] = device
        for hardware, device in known.items():
            assert hardware in truth, f"{device.id} is a ghost: it was withdrawn"
            self.check(truth[hardware], device)
        lost = [lamp for hardware, lamp in truth.items() if lamp.is_alive and hardware not in known]
        assert not lost

    def check(self, lamp: Lamp, device: Device) -> None:
        silent = self.clock.now() - lamp.sign
        assert lamp.is_alive or silent <= lamp.time_to_live(), f"{device.id} is a ghost: silent for {silent:.0f} s"
        assert device.name == lamp.name
        assert [part.part.service_type for part in device.parts] == ["light"]
        assert len(device.parts[0].routes) == (2 if lamp.kind == "both" else 1)
        assert not device.conflicts
        if lamp.is_alive and lamp.has_spoken:
            said = [state.value.plain() for state in device.states if state.capability == "on_off"]
            assert said == [lamp.is_on], f"{lamp} is {device.states}"
        assert lamp.device_id in {"", device.id}, f"{lamp.device_id} is called {device.id} now"
        lamp.device_id = device.id


@pytest.mark.no_cover
@pytest.mark.virtual_time
@pytest.mark.parametrize("seed", range(SEEDS))
async def test_in_a_house_that_changes_all_the_time_nothing_is_lost_merged_or_a_ghost(seed: int) -> None:
    """Thousands of events; then the dead have their time, and are gone."""
    async with _churn(seed) as churn:
        for number in range(EVENTS):
            await churn.step()
            if number % (EVENTS // LOOKS) == 0:
                await churn.look()
        dead = [lamp for lamp in churn.lamps if lamp.is_listed and not lamp.is_alive]
        end = max((lamp.sign + lamp.time_to_live() for lamp in dead), default=0.0)
        while churn.clock.now() < end:
            for lamp in [one for one in churn.lamps if one.is_alive]:
                await churn.report(lamp)
            await anyio.sleep(3000.0)
        await churn.look()
        alive = {lamp.device_id for lamp in churn.lamps if lamp.is_alive}
        assert {device.id for device in churn.directory.index.devices()} == alive
        await churn.broker.restart(keep_sessions=True)  # and tells of the dead again
        await anyio.sleep(60.0)
        assert {device.id for device in churn.directory.index.devices()} == alive
        ids = [lamp.device_id for lamp in churn.lamps if lamp.device_id]
        assert len(set(ids)) == len(ids)
        assert churn.deaths > size(10, 50)


@asynccontextmanager
async def _churn(seed: int) -> AsyncIterator[Churn]:
    clock = LoopClock(1_767_225_600.0)
    graph = Graph(clock=clock)
    dice = Random(seed)  # noqa: S311 - the same run each time
    async with (
        MemoryBroker(clock=clock, random=dice) as broker,
        Node(graph, "mqtt", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        MqttConnection(
            MqttOptions.from_url(broker.url), broker.make_client, status_topic=None, clock=clock, random=dice
        ) as wire,
        anyio.create_task_group() as tasks,
    ):
        settings = MqttGatewaySettings(url=broker.url, stale_after=STALE_AFTER, conventions=CONVENTIONS)
        gateway = MqttGateway(gateway_node, settings, GatewayContext.of(HostedBroker.in_memory(broker), random=dice))
        directory = Directory(directory_node, DirectorySettings(forget_after=FORGET_AFTER))
        await tasks.start(directory.serve)
        await tasks.start(gateway.serve)
        await wire.wait_connected()
        churn = Churn(broker, directory, gateway, wire, clock, dice)
        await churn.say("zigbee2mqtt/bridge/state", {"state": "online"}, retain=True)
        yield churn
        tasks.cancel_scope.cancel()


def _config_topic(lamp: Lamp) -> str:
    return f"homeassistant/light/{lamp.ieee if lamp.kind != 'firmware' else f'esp-{lamp.number}'}/light/config"


def _config(lamp: Lamp) -> dict[str, object]:
    topic, is_json = lamp.availability()
    sources = [{"topic": topic, **({"value_template": "{{ value_json.state }}"} if is_json else {})}]
    identity: dict[str, object] = {"identifiers": [f"zigbee2mqtt_{lamp.ieee}"]}
    if lamp.kind == "firmware":
        shared = ["ESP32", "our own firmware 1.0"]  # says what it is, not who
        identity = {"identifiers": [f"esp-{lamp.number}", *shared], "connections": [["mac", lamp.mac]]}
    return {
        "schema": "json",
        "name": None,
        "unique_id": "light" if lamp.kind == "firmware" else f"{lamp.ieee}_light_zigbee2mqtt",
        "brightness": True,
        "brightness_scale": 254,
        "state_topic": lamp.topic,
        "command_topic": f"{lamp.topic}/set",
        "device": {**identity, "name": lamp.name, "model": "LED2003G10", "manufacturer": "IKEA"},
        **({"availability": sources} if lamp.watches else {}),
    }
