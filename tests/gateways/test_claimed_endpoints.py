"""A stranger on the network claims to be a lamp of another gateway, whose link then fails; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.devices import Devices
from homebot.devices.handles import DoorLock, Light
from homebot.discovery.directory import Directory, DirectorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node

pytestmark = pytest.mark.virtual_time

MAC = ("mac:aabbccddeeff",)


class House:
    """A house with two gateways: the lamp's own, and one on which a stranger may announce what it likes."""

    def __init__(self, app: Node, own: MemoryGateway, other: MemoryGateway) -> None:
        self.devices = Devices(app)
        self.own = own
        self.other = other

    async def announce(self, service_type: str, capability: str) -> None:
        """Let the device appear in its gateway, and then a stranger with its hardware address in the other one."""
        part = simple_part(service_type, settable=(capability,))
        self.own.devices.put(GatewayDevice("true", "Hall", (part,), identifiers=MAC), "it was announced")
        self.other.devices.put(GatewayDevice("evil", "Evil", (part,), identifiers=MAC), "it was announced")
        await anyio.wait_all_tasks_blocked()


@asynccontextmanager
async def house() -> AsyncIterator[House]:
    graph = Graph()
    async with (
        Node(graph, "discovery") as directory,
        Node(graph, "own", namespace="/gateway") as own,
        Node(graph, "other", namespace="/gateway") as other,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        made = House(app, MemoryGateway(own), MemoryGateway(other))
        await tasks.start(made.own.serve)
        await tasks.start(made.other.serve)
        await tasks.start(Directory(directory, DirectorySettings(persist=False)).serve)
        yield made
        tasks.cancel_scope.cancel()


async def test_a_stranger_does_not_get_the_commands_of_a_lamp_while_its_gateway_is_away() -> None:
    async with house() as the:
        await the.announce("light", "on_off")
        (lamp,) = await the.devices.find(Light)
        await lamp.turn_on()
        the.own.set_unavailable("somebody pulled the plug")
        assert "pulled the plug" in (await lamp.turn_off()).text
        assert (len(the.own.commands), len(the.other.commands)) == (1, 0)


async def test_a_stranger_cannot_say_that_a_door_is_locked() -> None:
    async with house() as the:
        await the.announce("door_lock", "lock")
        await the.own.devices.report("true", {"lock": "unlocked"})
        await the.other.devices.report("evil", {"lock": "locked"})
        await anyio.wait_all_tasks_blocked()
        (door,) = await the.devices.find(DoorLock)
        assert door.state == "unlocked"
        await door.lock()
        assert (len(the.own.commands), len(the.other.commands)) == (1, 0)


async def test_a_lamp_that_is_seen_twice_is_reached_by_its_other_gateway() -> None:
    """Once it has shown that both are the same lamp: a command by one shows in what the other reports."""
    async with house() as the:
        await the.announce("light", "on_off")
        (lamp,) = await the.devices.find(Light)
        for is_on in (False, True, False, True):
            await (lamp.turn_on() if is_on else lamp.turn_off())
            await the.other.devices.report("evil", {"on_off": is_on})
            await anyio.sleep(60)
        (lamp,) = await the.devices.find(Light)
        the.own.set_unavailable("somebody pulled the plug")
        await lamp.turn_off()
        assert (len(the.own.commands), len(the.other.commands)) == (4, 1)
