"""People after a restart of homebot, on a broker that keeps the last message of a phone; in virtual time."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from random import Random

import anyio
import pytest

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.devices import Devices
from homebot.graph import Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("owntracks")]

CONFIG = parse_config({"gateways": {"mqtt": {}}, "people": {"Ben": {"trackers": ["ben phone"]}}}, "test")


@asynccontextmanager
async def homebot(folder: Path, broker: MemoryBroker, clock: LoopClock) -> AsyncIterator[Node]:
    """Run a homebot that remembers."""
    services, index = [HostedBroker.in_memory(broker)], folder / "index.sqlite"
    async with (
        Runtime(CONFIG, with_door=False, clock=clock, services=services, index_file=index) as runtime,
        Node(runtime.graph, "test") as node,
    ):
        await anyio.sleep(10)
        yield node


async def ben(node: Node) -> object:
    (found,) = await Devices(node).find("person")
    return found.states[0].value.plain()


async def test_what_a_phone_told_last_holds_after_a_restart_for_a_day(tmp_path: Path) -> None:
    clock, random = LoopClock(), Random(0)  # noqa: S311 - a test has no secrets
    async with MemoryBroker(clock=clock, random=random) as broker:
        options = MqttOptions(host=broker.host, port=broker.port, client_id="phone")
        async with MqttConnection(options, broker.make_client, status_topic=None, clock=clock, random=random) as phone:
            await phone.wait_connected()

            async def tell(told_at: int, *regions: str) -> None:
                message = {"_type": "location", "inregions": list(regions), "tst": told_at}
                await phone.publish("owntracks/ben/phone", json.dumps(message).encode(), qos=1, retain=True)
                await anyio.sleep(35)

            async with homebot(tmp_path, broker, clock) as node:
                await tell(1, "Home")
                assert await ben(node) is True
            async with homebot(tmp_path, broker, clock) as node:
                assert await ben(node) is True  # at once
                await anyio.sleep(8 * 3_600)
                assert await ben(node) is True
                await tell(0)  # late
                assert await ben(node) is True
                await anyio.sleep(86_400)
                assert await ben(node) is None
                await tell(2, "Home")
                assert await ben(node) is True
                await tell(3)
                assert await ben(node) is False
