"""Routines in a simulated flat in virtual time."""

import json
from collections.abc import Mapping

import pytest
from tests.apps.houses import hall, is_on, lamp, motion

from homebot.devices.app_messages import (
    ChangeAppRequest,
    ChangeRoutine,
    ChangeRoutineRequest,
    ListRoutines,
    ReloadApp,
    RoutinesRequest,
)
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES, RELOAD_APP
from homebot.errors import ConfigError
from homebot.graph import Node
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

NIGHT_LIGHT: dict[str, object] = {
    "name": "Hall light",
    "when": ["hall motion occupied"],
    "do": ["hall lamp on", "wait until hall motion clear for 2m, at most 30m", "undo"],
    "mode": "restart",
}


def config(*routines: Mapping[str, object], **home: object) -> dict[str, object]:
    return {"routines": list(routines), "home": {"zone": "UTC", **home}}


async def test_a_lamp_is_on_while_somebody_moves_and_goes_back_afterwards() -> None:
    world = hall(("08:00", "hall"), ("08:05", "outside"))
    async with virtual_house_of(world=world, config=config(NIGHT_LIGHT)) as house:
        await house.run_until("07:59")
        assert not is_on(world, "hall_lamp")
        await house.run_until("08:01")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:30")
        assert not is_on(world, "hall_lamp")


async def test_a_run_that_starts_anew_brings_back_what_was_before_the_first() -> None:
    """Anna looks into the hall three times."""
    visits = [(f"08:0{minute}", "hall" if minute % 2 else "study") for minute in range(1, 7)]
    world = hall(*visits, ("08:07", "outside"))
    async with virtual_house_of(world=world, config=config(NIGHT_LIGHT)) as house:
        await house.run_until("08:06:30")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:30")
        assert not is_on(world, "hall_lamp")


async def test_what_a_person_changed_meanwhile_is_not_undone() -> None:
    world = hall(("08:00", "hall"), ("08:05", "outside"))
    routine = NIGHT_LIGHT | {"do": ["hall lamp on, 20 %", "wait until hall motion clear for 2m, at most 30m", "undo"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_until("08:02")
        await house.press("hall_lamp", "off")
        await house.press("hall_lamp", "on")
        await house.run_until("08:30")
        assert is_on(world, "hall_lamp")


async def test_a_condition_holds_it_back() -> None:
    world = hall(("08:00", "hall"), ("08:05", "outside"))
    routine = NIGHT_LIGHT | {"if": ["after 20:00"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_until("08:01")
        assert not is_on(world, "hall_lamp")


async def test_a_trigger_that_is_held_back_leaves_the_run_that_waits() -> None:
    """It made the hall too bright for the second motion, which ended the first run: the light stayed on for ever."""
    world = hall(("08:00", "hall"), ("08:01", "study"), ("08:05", "hall"), ("08:06", "study"))
    routine = NIGHT_LIGHT | {"if": ["not hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_until("08:07")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:30")
        assert not is_on(world, "hall_lamp")


async def test_a_time_of_day_starts_it() -> None:
    world = hall()
    routine = {"name": "Evening", "when": ["18:30"], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_until("18:29")
        assert not is_on(world, "hall_lamp")
        await house.run_until("18:31")
        assert is_on(world, "hall_lamp")


async def test_the_sun_starts_it() -> None:
    world = hall()
    routine = {"name": "Dusk", "when": ["sunset - 30m"], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine, latitude=52.5, longitude=13.4)) as house:
        await house.run_until("14:20")
        assert not is_on(world, "hall_lamp")
        await house.run_until("14:45")  # the sun sets at 15:02 UTC
        assert is_on(world, "hall_lamp")


@pytest.mark.parametrize(
    ("condition", "latitude", "holds"),
    [
        ("after sunset - 30m", 52.5, (False, True)),  # the sun sets at 15:02 UTC, and rises at 7:16
        ("before sunset - 30m", 52.5, (True, True)),
        ("between sunset - 30m and sunrise + 7h", 52.5, (True, True)),
        ("between sunrise + 7h and 14:35", 52.5, (False, False)),
        ("after sunset + 12h", 52.5, (False, False)),
        ("after sunset", 80.0, (False, False)),  # it does not rise all winter
    ],
)
async def test_the_sun_tells_a_part_of_the_day(condition: str, latitude: float, holds: tuple[bool, bool]) -> None:
    world = hall()
    routine = {"name": "Dusk", "when": ["14:10", "14:45"], "if": [condition], "do": ["hall lamp on"]}
    async with virtual_house_of(
        world=world, config=config(routine, latitude=latitude, longitude=13.4), start="2026-01-01 14:00"
    ) as house:
        await house.run_until("14:15")
        early = is_on(world, "hall_lamp")
        await house.run_until("14:50")
        assert (early, is_on(world, "hall_lamp")) == holds


async def test_a_state_that_lasts_starts_it() -> None:
    world = hall(kitchen_lamp=lamp("kitchen"))
    routine = {"name": "Forgotten", "when": ["hall lamp on for 10m"], "do": ["kitchen lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_for("1m")
        await house.press("hall_lamp", "on")
        await house.run_for("9m")
        assert not is_on(world, "kitchen_lamp")
        await house.run_for("2m")
        assert is_on(world, "kitchen_lamp")


async def test_what_was_so_before_it_began_starts_nothing() -> None:
    """A restart of homebot or a reload of the routine in an occupied room turns nothing on."""
    world = hall(("08:00", "hall"))
    async with virtual_house_of(world=world, config=config(NIGHT_LIGHT)) as house:
        await house.run_until("08:01")
        await house.press("hall_lamp", "off")
        async with Node(house.runtime.graph, "owner") as owner:
            client = owner.create_client(ReloadApp, RELOAD_APP)
            assert (await client.call(ChangeAppRequest(app="hall_light"))).message == "reloaded the app hall_light"
        await house.run_for("1m")
        assert not is_on(world, "hall_lamp")


async def test_a_run_goes_on_after_a_restart_in_its_wait() -> None:
    world = hall(("08:00", "hall"), ("08:05", "outside"))
    async with virtual_house_of(world=world, config=config(NIGHT_LIGHT)) as house:
        await house.run_until("08:01")
        async with Node(house.runtime.graph, "owner") as owner:
            await owner.create_client(ReloadApp, RELOAD_APP).call(ChangeAppRequest(app="hall_light"))
        await house.run_until("08:05")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:30")
        assert not is_on(world, "hall_lamp")


async def test_runs_beside_each_other_all_go_on_after_a_restart() -> None:
    world = hall(bar=lamp("hall"))
    parallel = {
        "name": "Parallel",
        "when": ["08:00", "08:10"],
        "do": [{"if": ["before 8:05"], "do": ["hall lamp on", "wait 1h", "hall lamp off"],
                "else": ["bar on", "wait 2h", "bar off"]}],
        "mode": "parallel",
    }  # fmt: skip
    async with virtual_house_of(world=world, config=config(parallel), start="2026-01-01 07:50") as house:
        await house.run_until("08:30")
        async with Node(house.runtime.graph, "owner") as owner:
            await owner.create_client(ReloadApp, RELOAD_APP).call(ChangeAppRequest(app="parallel"))
        await house.run_until("08:59")
        assert (is_on(world, "hall_lamp"), is_on(world, "bar")) == (True, True)
        await house.run_until("09:01")
        assert (is_on(world, "hall_lamp"), is_on(world, "bar")) == (False, True)
        async with Node(house.runtime.graph, "owner") as owner:
            await owner.create_client(ReloadApp, RELOAD_APP).call(ChangeAppRequest(app="parallel"))
        await house.run_until("10:11")
        assert not is_on(world, "bar")


async def test_a_message_that_nobody_got_is_a_failure() -> None:
    message = {"name": "Message", "when": ["08:00"], "do": ["notify Good morning"]}
    async with (
        virtual_house_of(world=hall(), config=config(message), start="2026-01-01 07:50") as house,
        Node(house.runtime.graph, "owner") as owner,
    ):
        await house.run_until("08:01")
        (found,) = (await owner.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest())).routines
    assert "'notify Good morning' failed: nobody was told" in found.notes[-1].text


async def test_a_press_starts_it() -> None:
    world = hall()
    button = {"unique_id": "b", "name": "hall button", "state_topic": "b", "event_types": ["single", "double"]}
    routine = {"name": "Button", "when": ["hall button press double"], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.says("homeassistant/event/b/config", json.dumps(button | {"device_class": "button"}))
        await house.run_for("1m")
        await house.says("b", '{"event_type": "single"}')
        await house.run_for("10s")
        assert not is_on(world, "hall_lamp")
        await house.says("b", '{"event_type": "double"}')
        await house.run_for("10s")
        assert is_on(world, "hall_lamp")


async def test_it_is_listed_switched_off_and_started_by_hand() -> None:
    world = hall(("08:00", "hall"), ("08:05", "outside"))
    async with (
        virtual_house_of(world=world, config=config(NIGHT_LIGHT)) as house,
        Node(house.runtime.graph, "owner") as owner,
    ):
        change = owner.create_client(ChangeRoutine, CHANGE_ROUTINE)
        listing = owner.create_client(ListRoutines, LIST_ROUTINES)
        answer = await change.call(ChangeRoutineRequest(name="hall LIGHT", change="disable"))
        assert answer.message == "disabled Hall light"
        await house.run_until("08:01")
        assert not is_on(world, "hall_lamp")
        answer = await change.call(ChangeRoutineRequest(name="Hall light", change="run"))
        assert answer.message == "started Hall light"
        await house.run_for("10s")
        assert is_on(world, "hall_lamp")
        (found,) = (await listing.call(RoutinesRequest())).routines
        assert (found.name, found.app, found.enabled, found.is_running) == ("Hall light", "hall_light", False, True)
        assert [one.text for one in found.notes] == ["ran"]
        answer = await change.call(ChangeRoutineRequest(name="hall lite", change="run"))
        assert answer.message == "there is no routine 'hall lite'; did you mean Hall light?"


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"when": ["hall lamp"]}, "routines.hall_light.when.0: 'hall lamp' names no state"),
        ({"do": ["hall lamp onn"]}, "did you mean on"),
        ({"when": ["22:00", "22:00"]}, "when: '22:00' is there twice"),
        ({"do": ["undo"]}, "nothing to undo"),
        ({"when": ["hall lamp on"], "do": ["hall lamp on"]}, "would start itself"),
        ({"mode": "often"}, "routines.hall_light.mode"),
        ({"then": []}, "routines.hall_light.then"),
        ({"name": ""}, "routines.routine_1.name: must be a name"),
    ],
)
async def test_a_mistake_is_an_error_with_its_place(change: dict[str, object], problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        async with virtual_house_of(world=hall(), config=config(NIGHT_LIGHT | change)):
            pytest.fail("it starts")


@pytest.mark.parametrize(
    "routine",
    [
        {"when": ["no motion for 5m"], "do": ["hall lamp off"]},
        {"when": ["hall motion occupied"], "do": ["wait until no motion for 5m, at most 30m", "hall lamp off"]},
    ],
)
async def test_no_motion_waits_for_the_last_of_several_sensors(routine: dict[str, object]) -> None:
    world = hall(("08:00", "hall"), ("08:05", "study"), ("08:10", "outside"), study_motion=motion("study"))
    light = {"name": "Light", "when": ["hall motion occupied"], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(light, {"name": "Dark", **routine})) as house:
        await house.run_until("08:13")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:20")
        assert not is_on(world, "hall_lamp")
