"""Misspelt rooms, devices and queries in the configuration: told once devices had time to come; in virtual time."""

import pytest
from structlog.testing import capture_logs
from tests.apps.houses import flat, lamp, motion

from homebot.apps import App
from homebot.devices.handles import Light
from homebot.devices.health import GetHealth
from homebot.devices.misspelt_names import UNKNOWN_NAME
from homebot.devices.names import PLACE_DEVICE
from homebot.devices.places_messages import PlaceDevice
from homebot.graph import Node
from homebot.house import World
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

ROOM = "rooms: there is no room 'Halll'; did you mean hall?"


def world() -> World:
    lux: dict[str, object] = {"kind": "lux", "room": "hall"}
    return flat(hall_lamp=lamp("hall"), hall_motion=motion("hall"), hall_lux=lux)


async def troubles(node: Node, name: str) -> tuple[str, ...]:
    return (await node.create_client(GetHealth, f"/{name}/health").call(GetHealth.Request())).troubles


async def test_a_misspelt_room_of_an_app_is_told_when_devices_had_time_to_come() -> None:
    config = {"apps": {"follow_me": {"rooms": ["Hall", "Halll"]}}}
    with capture_logs() as lines:
        async with virtual_house_of(world=world(), config=config) as house, Node(house.runtime.graph, "doctor") as node:
            await house.run_for("290s")
            assert await troubles(node, "follow_me") == ()
            assert [one for one in lines if one["event"] == UNKNOWN_NAME] == []
            await house.run_for("20s")
            assert await troubles(node, "follow_me") == (ROOM,)
            await house.run_for("10m")
    told = [(one["log_level"], one["message"]) for one in lines if one["event"] == UNKNOWN_NAME]
    assert told == [("warning", f"{ROOM} (looked for 5 minutes)")]


async def test_a_room_that_a_device_comes_to_later_is_no_problem_any_more() -> None:
    config = {"apps": {"follow_me": {"rooms": ["Halll"]}}}
    async with virtual_house_of(world=world(), config=config) as house, Node(house.runtime.graph, "doctor") as node:
        await house.run_for("310s")
        assert await troubles(node, "follow_me") == (ROOM,)
        place = PlaceDevice.Request(device="hall_lamp", room="Halll", is_new=True)
        assert (await node.create_client(PlaceDevice, PLACE_DEVICE).call(place)).success
        assert await troubles(node, "follow_me") == ()


async def test_an_app_serves_a_room_that_gets_its_first_device_later() -> None:
    """There is a similar one: the app crashed five times within a minute, and was given up."""
    config = {"apps": {"halle": {"class": f"{__name__}:Halle"}}}
    problem = "halle: follow(Light, area='Halle', on=True): no device is in 'halle'; did you mean hall? Until"
    async with virtual_house_of(world=world(), config=config) as house, Node(house.runtime.graph, "doctor") as node:
        await house.run_for("2m")
        assert [one.startswith(problem) for one in await troubles(node, "homebot")] == [True]
        assert house.crashed == ()
        place = PlaceDevice.Request(device="hall_lamp", room="Halle", is_new=True)
        assert (await node.create_client(PlaceDevice, PLACE_DEVICE).call(place)).success
        await house.settle()
        assert await troubles(node, "homebot") == ()
        await house.press("hall_lamp", "on")
        await house.becomes("hall_lamp", on=False, within="5s")


class Halle(App):
    async def run(self) -> None:
        self.on(self.devices.follow(Light, area="Halle", on=True).only("appeared"), lambda one: one.handle.turn_off())


async def test_a_room_that_the_owner_states_may_be_empty() -> None:
    config = {"apps": {"follow_me": {"rooms": ["attic"]}}, "places": {"rooms": {"Attic": {}}}}
    async with virtual_house_of(world=world(), config=config) as house, Node(house.runtime.graph, "doctor") as node:
        await house.run_for("310s")
        assert await troubles(node, "follow_me") == ()


@pytest.mark.parametrize(
    ("table", "problems"),
    [
        ({"witnesses": {"light in hall": "Hall_lux", "plug": ""}}, ("control.witnesses: no device fits 'plug'; ",)),
        (
            {"witnesses": {"light": "hall_lxu"}},
            ("control.witnesses.'light': there is no device 'hall_lxu'; did you mean hall_lux",),
        ),
        (
            {"presence_guard": {"doors": {"hal": ["hall_dor"]}}},
            (
                "control.presence_guard.doors: there is no room 'hal'; did you mean hall?",
                "control.presence_guard.doors.hal: there is no device 'hall_dor'; ",
            ),
        ),
        (
            {
                "quiet_hours": [
                    {"start": "22:00", "end": "06:00", "commands": ["turn on light in halll", "unlock locks"]}
                ]
            },
            ("control.quiet_hours: 'turn on light in halll': no device is in 'halll'; did you mean hall?",),
        ),
        (
            {"witnesses": {"light in halll": ""}},
            ("control.witnesses: no device fits 'light in halll'; no device is in 'halll'; did you mean hall?",),
        ),
        ({"timeout": 5.0}, ()),
    ],
)
async def test_misspelt_names_of_the_control_layer_are_told(
    table: dict[str, object], problems: tuple[str, ...]
) -> None:
    with capture_logs() as lines:
        config = {"control": table}
        async with virtual_house_of(world=world(), config=config) as house, Node(house.runtime.graph, "doctor") as node:
            await house.run_for("310s")
            found = await troubles(node, "control")
    logged = [one["message"] for one in lines if one["event"] == UNKNOWN_NAME]
    assert len(found) == len(logged) == len(problems)
    for one, line, problem in zip(found, logged, problems, strict=True):
        assert one.startswith(problem)
        assert line.startswith(one)


async def test_a_group_or_a_room_in_a_right_that_nobody_has_is_told_with_its_key() -> None:
    groups = [{"name": "Evening", "members": "lights"}]
    rights = {"act": ['group="Evening"', 'group="Evenin"', "lights in halll"]}
    config = {"groups": groups, "apps": {"light_service": rights}, "door": {"scope": ["read", "ask: group=Noon"]}}
    async with virtual_house_of(world=world(), config=config) as house, Node(house.runtime.graph, "doctor") as node:
        await house.run_for("310s")
        assert await troubles(node, "control") == (
            "[apps.light_service] act: 'act: group=\"Evenin\"': "
            "no device is in a group 'evenin'; did you mean evening?",
            "[apps.light_service] act: 'act: lights in halll': no device is in 'halll'; did you mean hall?",
            "door.scope: 'ask: group=Noon': no device is in a group 'noon'; `homebot group list` shows all",
        )
