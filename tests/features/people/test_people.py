"""People and their household, by the trackers of a house; in virtual time."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.errors import ConfigError
from homebot.graph import Node
from homebot.runtime.plan import make_plan
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = pytest.mark.virtual_time

ANNA = {"trackers": ["Anna's phone"], "away_after": "20m"}
BEN = {"trackers": ["ben phone"]}
HEARD = json.dumps({"id": "phone:anna", "name": "Anna's phone", "rssi": -70, "distance": 3.2})


@asynccontextmanager
async def house_with(people: dict[str, object]) -> AsyncIterator[VirtualHouse]:
    async with virtual_house_of(config={"people": people, "home": {"zone": "UTC"}}) as house:
        await house.run_for(1)
        yield house


async def at_home(house: VirtualHouse) -> dict[str, object]:
    async with Node(house.runtime.graph, "test") as node:
        devices = [one for one in await Devices(node).find() if one.service_type in {"x_person", "x_household"}]
    return {one.name: one.states[0].value.plain() if one.states else None for one in devices}


async def heard(house: VirtualHouse, minutes: int = 0) -> None:
    """Let a node hear Anna's phone now, and once a minute."""
    await house.says("espresense/rooms/kitchen/status", "online")
    for _ in range(minutes + 1):
        await house.says("espresense/devices/phone:anna/kitchen", HEARD)
        await house.run_for(60 if minutes else 2)


async def is_in(house: VirtualHouse, *regions: str) -> None:
    message = {"_type": "location", "tst": 1} | ({"inregions": list(regions)} if regions else {})
    await house.says("owntracks/ben/phone", json.dumps(message))
    await house.run_for(2)


async def test_nothing_is_known_of_people_before_their_phones_tell() -> None:
    async with house_with({"Anna": ANNA, "Ben": BEN}) as house:
        assert await at_home(house) == {"Anna": None, "Ben": None, "Household": None}


@pytest.mark.rooms("espresense", "owntracks")
async def test_the_household_is_home_with_its_first_and_away_with_its_last() -> None:
    async with house_with({"Anna": ANNA, "Ben": BEN}) as house:
        await is_in(house, "Home")
        assert await at_home(house) == {"Anna": None, "Ben": True, "Household": True}
        await is_in(house)
        assert await at_home(house) == {"Anna": None, "Ben": False, "Household": None}
        await heard(house)
        assert await at_home(house) == {"Anna": True, "Ben": False, "Household": True}


@pytest.mark.rooms("espresense")
async def test_a_phone_that_falls_silent_is_unknown_and_then_away() -> None:
    async with house_with({"Anna": ANNA}) as house:
        await heard(house, minutes=5)
        assert (await at_home(house))["Household"] is True
        await house.run_for("4m")
        assert (await at_home(house))["Household"] is None
        await house.run_for("14m")
        assert (await at_home(house))["Household"] is None
        await house.run_for("6m")
        assert (await at_home(house))["Household"] is False


@pytest.mark.rooms("espresense")
async def test_the_silence_of_nodes_that_are_offline_means_nothing() -> None:
    async with house_with({"Anna": ANNA}) as house:
        await heard(house)
        await house.says("espresense/rooms/kitchen/status", "offline")
        await house.run_for("2h")
        assert (await at_home(house))["Anna"] is None
        await house.says("espresense/rooms/kitchen/status", "online")
        await house.run_for("10m")
        assert (await at_home(house))["Anna"] is None
        await house.run_for("15m")
        assert (await at_home(house))["Anna"] is False


@pytest.mark.rooms("owntracks")
async def test_a_phone_that_stays_where_it_is_may_be_silent_for_a_day() -> None:
    async with house_with({"Ben": BEN}) as house:
        await is_in(house, "Home")
        await house.run_for("20h")
        assert (await at_home(house))["Ben"] is True
        await house.run_for("6h")
        assert (await at_home(house))["Ben"] is None


async def test_people_do_not_become_stale() -> None:
    async with house_with({"Ben": BEN}) as house:
        await house.run_for("3h")
        async with Node(house.runtime.graph, "test") as node:
            assert [one.freshness for one in await Devices(node).find("person")] == ["fresh"]


@pytest.mark.rooms("homeassistant")
async def test_a_tracker_of_discovery_counts() -> None:
    async with house_with({"Ben": {"trackers": ["Ben's watch"]}}) as house:
        found = {"name": "Ben's watch", "state_topic": "ben/watch", "unique_id": "w1", "device": {"identifiers": "w"}}
        await house.says("homeassistant/device_tracker/w1/config", json.dumps(found))
        await house.run_for(1)
        for place, is_home in (("home", True), ("not_home", False), ("Work", False), ("None", None)):
            await house.says("ben/watch", place)
            await house.run_for(2)
            assert (await at_home(house))["Ben"] is is_home, place


@pytest.mark.parametrize(
    ("people", "key", "reason"),
    [
        ({"Anna": {}}, "people.Anna", "give `trackers`"),
        ({"Anna": {"pings": "x"}}, "people.Anna.pings", "unknown key"),
        ({"Anna": {"ping": "a; rm"}}, "people.Anna.ping", "pattern"),
        ({"Anna": {"ping": "10.0.0.1", "away_after": "5s"}}, "people.Anna.away_after", "60"),
        ([], "people", "must be a table"),
    ],
)
def test_mistakes_are_named_with_their_key(people: object, key: str, reason: str) -> None:
    with pytest.raises(ConfigError) as caught:
        make_plan(parse_config({"people": people}, "homebot.toml"))
    assert (caught.value.key, reason in caught.value.reason) == (key, True), caught.value
