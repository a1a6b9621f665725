"""People after a restart of homebot, on a broker that keeps the last message of a phone; in virtual time."""

import json
import tomllib
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from random import Random

import anyio
import pytest
from tests.guide import blocks_in, guide

from homebot.clock import LoopClock
from homebot.config import Config, parse_config
from homebot.devices import Devices
from homebot.graph import Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("espresense", "homeassistant", "owntracks")]

PEOPLE = tomllib.loads("\n".join(blocks_in(guide("people"), "toml")))["people"]
del PEOPLE["Anna"]["ping"]  # there is no network in virtual time
CONFIG = parse_config({"gateways": {"mqtt": {}}, "home": {"zone": "UTC"}, "people": PEOPLE}, "test")

Tell = Callable[[str, object], Awaitable[None]]
"""Publishes a message, which the broker keeps: an object, or a text as it is."""

PHONE = {"name": "Anna's phone", "unique_id": "phone", "state_topic": "anna/place", "source_type": "gps"}


@asynccontextmanager
async def broker_with_phone(clock: LoopClock) -> AsyncIterator[tuple[MemoryBroker, Tell]]:
    random = Random(0)  # noqa: S311 - a test has no secrets
    async with MemoryBroker(clock=clock, random=random) as broker:
        options = MqttOptions(host=broker.host, port=broker.port, client_id="phone")
        async with MqttConnection(options, broker.make_client, status_topic=None, clock=clock, random=random) as phone:
            await phone.wait_connected()

            async def tell(topic: str, message: object) -> None:
                text = message if isinstance(message, str) else json.dumps(message)
                await phone.publish(topic, text.encode(), qos=1, retain=True)
                await anyio.sleep(35)

            yield broker, tell


@asynccontextmanager
async def homebot(
    folder: Path, broker: MemoryBroker, clock: LoopClock, config: Config = CONFIG
) -> AsyncIterator[Callable[[], Awaitable[dict[str, object]]]]:
    """Run a homebot that remembers; the function tells who is at home by now."""
    services, index = [HostedBroker.in_memory(broker)], folder / "index.sqlite"
    async with (
        Runtime(config, with_door=False, clock=clock, services=services, index_file=index) as runtime,
        Node(runtime.graph, "test") as node,
    ):

        async def at_home() -> dict[str, object]:
            found = (*await Devices(node).find("person"), *await Devices(node).find("x_household"))
            return {one.name: one.states[0].value.plain() for one in found}

        await anyio.sleep(10)
        yield at_home


async def test_what_a_phone_told_last_holds_after_a_restart_for_a_day(tmp_path: Path) -> None:
    clock, config = (
        LoopClock(),
        parse_config({"gateways": {"mqtt": {}}, "people": {"Ben": {"trackers": ["ben phone"]}}}, "test"),
    )
    async with broker_with_phone(clock) as (broker, tell_phone):

        async def tell(told_at: int, *regions: str) -> None:
            await tell_phone("owntracks/ben/phone", {"_type": "location", "inregions": list(regions), "tst": told_at})

        async def ben(home: Callable[[], Awaitable[dict[str, object]]]) -> object:
            return (await home())["Ben"]

        async with homebot(tmp_path, broker, clock, config) as home:
            await tell(1, "Home")
            assert await ben(home) is True
        async with homebot(tmp_path, broker, clock, config) as home:
            assert await ben(home) is True  # at once
            await anyio.sleep(8 * 3_600)
            assert await ben(home) is True
            await tell(0)  # late
            assert await ben(home) is True
            await anyio.sleep(86_400)
            assert await ben(home) is None
            await tell(2, "Home")
            assert await ben(home) is True
            await tell(3)
            assert await ben(home) is False


@pytest.mark.parametrize("source", ["homeassistant", "owntracks", "espresense"])
async def test_the_people_of_the_guide_are_known_for_eight_hours_and_at_once_after_a_restart(
    tmp_path: Path, source: str
) -> None:
    """Anna's phone tells by each kind of tracker over MQTT; a node alone does not keep what it heard."""
    clock = LoopClock()
    async with broker_with_phone(clock) as (broker, tell):

        async def ben(told_at: int, *regions: str) -> None:
            await tell("owntracks/ben/phone", {"_type": "location", "inregions": list(regions), "tst": told_at})

        async def anna(told_at: int, place: str) -> None:
            if source == "homeassistant":
                await tell("homeassistant/device_tracker/phone/config", PHONE)
                await tell("anna/place", place)
            elif source == "owntracks":
                regions = ["Home"] if place == "home" else []
                message = {"_type": "location", "inregions": regions, "tst": told_at}
                await tell("owntracks/Anna's/phone", message)
            elif place == "home":
                heard = {"id": "phone:anna", "name": "Anna's phone", "rssi": -70}
                await tell("espresense/devices/phone:anna/kitchen", heard)

        async with homebot(tmp_path, broker, clock) as home:
            await ben(1, "Home")
            await anna(1, "home")
            assert await home() == {"Anna": True, "Ben": True, "Household": True}
            await anyio.sleep(8 * 3_600)
            is_anna_there = source != "espresense"
            assert await home() == {"Anna": is_anna_there, "Ben": True, "Household": True}
            await ben(40_000)
            assert await home() == {"Anna": is_anna_there, "Ben": False, "Household": is_anna_there}
            await anna(40_000, "not_home")
            away = {"Anna": False, "Ben": False, "Household": False}
            for _ in range(8):
                assert await home() == away
                await anyio.sleep(3_600)
        async with homebot(tmp_path, broker, clock) as home:
            expected = {"Anna": None, "Ben": False, "Household": None} if source == "espresense" else away
            for _ in range(8):
                assert await home() == expected
                await anyio.sleep(3_600)
