"""The owner's groups: read from the configuration, found by queries, listed with those of gateways; in virtual time."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import replace

import pytest
from tests.discovery import directory_house
from tests.discovery.announcements import announce, part_of
from tests.discovery.directory_house import House

from homebot.devices import FIND_DEVICES, FindDevices, KeyValue, Sighting, names
from homebot.devices.group_messages import GroupInfo, ListGroups, ListGroupsRequest
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.query.matching import groups_of
from homebot.devices.query.term_messages import query_terms
from homebot.devices.services import FindDevicesRequest
from homebot.discovery import OwnerFacts
from homebot.discovery.groups import read_groups
from homebot.discovery.house_rooms import HouseRooms
from homebot.errors import ConfigError
from homebot.places import NO_PLACES
from homebot.words.queries import parse_query

pytestmark = pytest.mark.virtual_time

EVENING = {"Evening": "lights in living or plug in hall"}


def lamp(key: str, area: str = "", kind: str = "light", *parts: str, members: tuple[str, ...] = ()) -> Sighting:
    described = [
        part_of(kind, "on_off", id=one, name=one.title(), writes=(f"{key}/{one}/set",)).model_copy(
            update={"members": members}
        )
        for one in parts or ("",)
    ]
    return announce(f"{kind}/{key}", *described, ids=(f"id:{key}",), name=key.title(), area=area)


HOUSE = (
    lamp("ceiling", "Living"),
    lamp("shelf", "Living"),
    lamp("kettle", "Hall", "plug"),
    lamp("porch", "Hall"),
    lamp("zigbee", "", "light", members=("id:ceiling", "id:shelf", "id:kettle")),
    lamp("others", "", "light", members=("id:porch", "id:away")),
)


@asynccontextmanager
async def house(queries: Mapping[str, str], *sightings: Sighting) -> AsyncIterator[House]:
    async with directory_house.directory(None, OwnerFacts("Home", replace(NO_PLACES, groups=queries))) as found:
        await found.hears(*(sightings or HOUSE))
        yield found


async def find(house: House, query: str) -> list[str]:
    request = FindDevicesRequest(query=query_terms(parse_query(query)))
    return [one.id for one in (await house.asker.create_client(FindDevices, FIND_DEVICES).call(request)).devices]


async def listed(house: House, name: str = "") -> dict[str, GroupInfo]:
    answer = await house.asker.create_client(ListGroups, names.LIST_GROUPS).call(ListGroupsRequest(name=name))
    assert answer.success, answer.message
    return {one.name: one for one in answer.groups}


@pytest.mark.parametrize(
    ("query", "ids"),
    [
        ("group=evening", ["ceiling", "kettle", "shelf"]),
        ('group="Evening" and light', ["ceiling", "shelf"]),
        ("lights not group=Evening", ["porch"]),
        ("evening lights", ["ceiling", "shelf"]),
        ("group=even", []),
    ],
)
async def test_a_query_finds_the_members_of_a_group_by_its_name(query: str, ids: list[str]) -> None:
    async with house(EVENING) as found:
        assert await find(found, query) == ids


@pytest.mark.parametrize("members", ["porsh or plug", "porc or plug", "plug"])
async def test_a_device_with_similar_words_is_no_member(members: str) -> None:
    async with house({"Own": members}) as found:
        assert await find(found, "group=Own") == ["kettle"]


async def test_a_group_of_some_parts_has_no_other_part_of_the_device() -> None:
    wall = lamp("wall", "Hall", "light", "left", "right")
    async with house({"Left": 'name="left" in hall'}, wall) as found:
        (info,) = (await listed(found)).values()
        assert [one.key for one in info.members] == ["wall#left"]


async def test_a_device_that_moves_to_the_room_of_a_group_joins_it() -> None:
    async with house(EVENING) as found:
        await found.place("porch", "Living")
        assert await find(found, "group=evening") == ["ceiling", "kettle", "porch", "shelf"]


@pytest.mark.parametrize(
    ("query", "ids"),
    [
        ("group=zigbee", ["ceiling", "kettle", "shelf"]),
        ("lights and group=Others", ["porch"]),
        ("group=zigbee or group=others", ["ceiling", "kettle", "porch", "shelf"]),
        ("group=both", ["ceiling", "kettle", "porch", "shelf"]),
        ("group=evening", ["porch"]),
    ],
)
async def test_the_groups_of_gateways_are_found_too_but_the_owners_outrank_them(query: str, ids: list[str]) -> None:
    own = {"Both": "group=zigbee or group=others", "Evening": "porch"}
    async with house(own, *HOUSE, lamp("evening", "", "light", members=("id:ceiling",))) as found:
        assert await find(found, query) == ids


async def test_a_group_of_a_gateway_whose_members_change_is_found_by_its_new_ones() -> None:
    async with house({}) as found:
        assert await find(found, "group=zigbee") == ["ceiling", "kettle", "shelf"]
        await found.hears(lamp("zigbee", members=("id:porch", "id:shelf")))
        assert await find(found, "group=zigbee") == ["porch", "shelf"]
        await found.hears(lamp("zigbee"))
        assert await find(found, "group=zigbee") == []


async def test_a_device_that_says_to_be_in_a_group_is_not() -> None:
    """Rights may name groups."""
    forged = lamp("forged").model_copy(update={"metadata": (KeyValue(key="group", value="Evening"),)})
    async with house(EVENING, *HOUSE, forged) as found:
        device = await found.device("forged")
        assert groups_of(device, device.parts[0].id) == []


async def test_groups_that_are_configured_anew_have_other_members_at_once() -> None:
    async with house(EVENING) as found:
        await found.directory.reconfigure(replace(NO_PLACES, groups={"Night": "porch"}), HouseRooms("Home", ()))
        assert await find(found, "group=night") == ["porch"]
        assert await find(found, "group=evening") == []
        await found.directory.reconfigure(NO_PLACES, HouseRooms("Home", ()))
        assert await find(found, "group=night") == []


async def test_the_list_tells_which_message_reaches_all_members() -> None:
    async with house({**EVENING, "Nothing": "robot"}) as found:
        groups = await listed(found)
        assert {name: one.reached_by for name, one in groups.items()} == {
            "Evening": ("zigbee",),
            "Nothing": (),
            "Zigbee": ("zigbee",),
            "Others": (),
        }
        assert [(one.key, one.value) for one in groups["Evening"].members] == [
            ("ceiling", "Ceiling"),
            ("kettle", "Kettle"),
            ("shelf", "Shelf"),
        ]
        assert not groups["Others"].is_complete
        for name in ("EVENING", '"Evening"', "the evening"):
            assert set(await listed(found, name)) == {"Evening"}


async def test_an_unknown_group_is_told_with_a_similar_one() -> None:
    async with house(EVENING) as found:
        answer = await found.asker.create_client(ListGroups, names.LIST_GROUPS).call(ListGroupsRequest(name="Evenin"))
        assert answer.message == "there is no group 'Evenin'; did you mean Evening?"


async def test_an_empty_group_is_a_note_of_the_health() -> None:
    async with house({**EVENING, "Nothing": "robot"}) as found:
        health = await found.asker.create_client(GetHealth, names.DISCOVERY_HEALTH).call(HealthRequest())
        assert health.notes == (
            "the group Nothing is empty: no device fits 'robot'; correct its members in [[groups]]",
        )


def test_a_group_may_be_made_of_others() -> None:
    tables = [{"name": "All", "members": 'group="Hall" or Garden'}, {"name": "Hall", "members": "lights in hall"}]
    assert list(read_groups(tables, "homebot.toml")) == ["All", "Hall"]


@pytest.mark.parametrize(
    ("tables", "problem"),
    [
        ([{"members": "lights"}], "groups.0.name"),
        ([{"name": "", "members": "lights"}], "groups.0.name: a name is empty"),
        ([{"name": "A\n", "members": "lights"}, {"name": "a", "members": "lights"}], "groups.1.name: there is a group"),
        ([{"name": "A"}], "groups.0.members"),
        ([{"name": "A", "members": "  "}], "groups.0.members: is empty"),
        ([{"name": "A", "members": "lights ("}], "groups.0.members: "),
        ([{"name": "A", "members": "on lights"}], "groups.0.members: 'on lights' depends on what changes"),
        ([{"name": "A", "members": "stale"}], "groups.0.members: 'stale' depends on what changes"),
        ([{"name": "A", "members": "a"}], "groups.0.members: the group 'A' contains itself"),
        (
            [{"name": "A", "members": "group=b or light"}, {"name": "B", "members": "not group=a"}],
            "groups.0.members: the group 'A' contains itself: A in B in A",
        ),
        ([{"name": "Hall", "members": "group=hal"}], "there is no group 'hal'; did you mean hall?"),
        ([{"name": "A", "members": "lights", "mebers": "x"}], "groups.0.mebers"),
    ],
)
def test_each_mistake_is_told_with_its_key(tables: list[dict[str, object]], problem: str) -> None:
    with pytest.raises(ConfigError) as error:
        read_groups(tables, "homebot.toml")
    assert problem in str(error.value)
