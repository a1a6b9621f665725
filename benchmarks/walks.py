"""How many Python calls, in how many files, lie between the network and an app: counted, not timed.

The runtime as ``homebot run`` starts it, but with client and broker in memory and on a virtual clock, so that every run
counts the same. Each walk is taken once before it is counted, so that models are built and caches are filled.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from random import Random

import anyio

from calls import CallCount
from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.devices import Devices, RawMessage
from homebot.devices.handles import Light
from homebot.errors import LinkError, RefusedError
from homebot.graph import Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.testing import VirtualTimeLoop
from plan import Plan
from raw_mqtt import connect_packet, publish_packet, subscribe_packet
from report import Report, verdict

__all__ = ["run"]

HOME = "home425"
AREA = "kitchen"
START = 1_767_225_600.0  # seconds since 1970: the first of January 2026
HEADINGS = ("walk", "calls", "aim", "files", "aim", "")


@dataclass(frozen=True, slots=True)
class Aim:
    """The most calls, and files, that a walk shall take."""

    calls: int
    files: int


AIMS = {
    "text message of a known device -> app -> command": Aim(100, 30),
    "announcement -> directory": Aim(250, 55),
    "JSON state -> index, searchable": Aim(180, 35),
    "find(Light, area=...)": Aim(80, 15),
    "turn_on -> socket": Aim(120, 28),
}


def run(_plan: Plan) -> Report:
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        counts = runner.run(_count())
    rows = [HEADINGS, *(_row(name, counts[name], aim) for name, aim in AIMS.items())]
    notes = [f"{name}: {_listed(count)}" for name, count in counts.items()]
    return Report("Walks: Python calls inside homebot, and the files they are in", (), notes, rows)


def _row(name: str, count: CallCount, aim: Aim) -> tuple[str, ...]:
    is_met = count.calls <= aim.calls and len(count.files) <= aim.files
    return name, str(count.calls), f"<= {aim.calls}", str(len(count.files)), f"<= {aim.files}", verdict(is_met)


def _listed(count: CallCount) -> str:
    return ", ".join(f"{file} {calls}" for file, calls in count.files.items())


async def _count() -> dict[str, CallCount]:
    async with _house() as house:
        names = iter(AIMS)
        return {
            next(names): await house.text_message(),
            next(names): await house.announcement(),
            next(names): await house.json_state(),
            next(names): await house.find(),
            next(names): await house.turn_on(),
        }


@asynccontextmanager
async def _house() -> AsyncIterator[House]:
    clock = LoopClock(START)
    random = Random(0)
    config = parse_config({"gateways": {"mqtt": {"root": HOME}}}, "benchmark")
    async with (
        MemoryBroker(clock=clock, random=random) as broker,
        Runtime(
            config, with_door=False, clock=clock, services=[HostedBroker.in_memory(broker)], random=random
        ) as runtime,
        Node(runtime.graph, "app") as node,
    ):
        house = House(Wire(broker), Devices(node))
        await _settled()
        yield house


class House:
    """Takes the walks, in the order of the methods.

    Args:
        wire: What the devices have of the network.
        devices: What the app has of the devices.
    """

    def __init__(self, wire: Wire, devices: Devices) -> None:
        self._wire = wire
        self._devices = devices

    async def text_message(self) -> CallCount:
        """A device says ``on``; the app, which listens to it, tells it ``off``."""
        self._wire.publish(f"{HOME}/lights/lamp/out", b"on")
        await _settled()
        (lamp,) = await self._devices.find("lights")

        async def on_message(_message: RawMessage) -> None:
            await self._devices.tell(lamp, "off")

        await self._devices.listen(lamp, on_message)

        async def walk() -> None:
            self._wire.publish(f"{HOME}/lights/lamp/out", b"on")

        count = await _second(walk)
        self._wire.expect(f"{HOME}/lights/lamp/in", b"off")
        return count

    async def announcement(self) -> CallCount:
        """Home Assistant discovery announces a lamp of Zigbee2MQTT."""
        numbers = iter(range(2))

        async def walk() -> None:
            self._wire.publish(*_announcement(next(numbers)))

        count = await _second(walk)
        assert len(await self._devices.find("light")) == 3
        return count

    async def json_state(self) -> CallCount:
        """One of them reports five values, some of them new each time."""
        levels = iter((100, 200))

        async def walk() -> None:
            self._report(next(levels))

        count = await _second(walk)
        (lamp,) = await self._devices.find(Light, name="lamp 0")
        assert lamp.on
        return count

    async def find(self) -> CallCount:
        """An app looks for it; a report came in between."""

        async def walk() -> None:
            assert len(await self._devices.find(Light, area=AREA)) == 1

        await walk()
        self._report(50)
        return await _counted(walk)

    async def turn_on(self) -> CallCount:
        """The app turns it on with some brightness, until that is on the wire; then the lamp answers."""
        (lamp,) = await self._devices.find(Light, area=AREA)
        levels = iter((60.0, 40.0))
        async with anyio.create_task_group() as tasks:

            async def walk() -> None:
                tasks.start_soon(lamp.set_level, next(levels))

            await walk()
            await _settled()
            self._report(153)
            count = await _counted(walk)
            self._wire.expect("zigbee2mqtt/lamp 0/set", b'{"state":"ON","brightness":102}')
            self._report(102)
        return count

    def _report(self, level: int) -> None:
        state = {"state": "ON", "brightness": level, "color_mode": "color_temp", "color_temp": 300, "linkquality": 90}
        self._wire.publish("zigbee2mqtt/lamp 0", json.dumps(state).encode())


def _announcement(number: int) -> tuple[str, bytes]:
    """Return the configuration of a lamp; the first is in the kitchen."""
    device = {"identifiers": [f"lamp_{number}"], "name": f"lamp {number}", "suggested_area": "" if number else AREA}
    config = {
        "name": None,
        "unique_id": f"lamp_{number}",
        "schema": "json",
        "brightness": True,
        "supported_color_modes": ["color_temp"],
        "state_topic": f"zigbee2mqtt/lamp {number}",
        "command_topic": f"zigbee2mqtt/lamp {number}/set",
        "device": device,
    }
    return f"homeassistant/light/lamp_{number}/config", json.dumps(config).encode()


class Wire:
    """The devices' side of the broker: bytes, since a client of homebot would be counted.

    Args:
        broker: The broker.
    """

    def __init__(self, broker: MemoryBroker) -> None:
        self._received = bytearray()
        self._socket = broker.dial(broker.host, broker.port, self)
        self._socket.write(connect_packet("devices") + subscribe_packet("#", 0))

    def publish(self, topic: str, payload: bytes) -> None:
        self._received.clear()
        self._socket.write(publish_packet(topic, payload))

    def expect(self, topic: str, payload: bytes) -> None:
        """Fail unless this came since the last publish."""
        assert publish_packet(topic, payload) in self._received, bytes(self._received)

    def data_received(self, data: bytes) -> None:
        self._received += data

    def drained(self) -> None:
        pass

    def link_ended(self, reason: LinkError | RefusedError) -> None:
        pass


async def _second(walk: Callable[[], Awaitable[None]]) -> CallCount:
    """Take the *walk* twice and count the second time."""
    await walk()
    await _settled()
    return await _counted(walk)


async def _counted(walk: Callable[[], Awaitable[None]]) -> CallCount:
    await _settled()
    with CallCount() as count:
        await walk()
        await _settled()
    return count


async def _settled() -> None:
    """Wait until all that can happen now has happened; no time passes."""
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualTimeLoop)
    await loop.settled()
