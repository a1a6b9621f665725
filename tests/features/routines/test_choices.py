"""Routines that choose between steps, in a simulated flat in virtual time."""

from collections.abc import Mapping

import pytest
from tests.apps.houses import hall, is_on, lamp

from homebot.devices.app_messages import ChangeAppRequest, ListRoutines, ReloadApp, RoutinesRequest
from homebot.devices.names import LIST_ROUTINES, RELOAD_APP
from homebot.errors import ConfigError
from homebot.features.routines.text import read_routines
from homebot.graph import Node
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

CHOICE = {
    "if": ["study lamp on"],
    "do": ["hall lamp on", "wait 10m", "hall lamp off"],
    "else": ["kitchen lamp on", "wait 10m", "kitchen lamp off"],
}
ROUTINE: dict[str, object] = {"name": "Choose", "when": ["18:00"], "do": [CHOICE, "study lamp off"]}


def config(routine: Mapping[str, object] = ROUTINE) -> dict[str, object]:
    return {"routines": [routine], "home": {"zone": "UTC"}}


@pytest.mark.parametrize(
    ("pressed", "taken", "left"), [("on", "hall_lamp", "kitchen_lamp"), ("off", "kitchen_lamp", "hall_lamp")]
)
async def test_one_of_two_ways_is_taken_and_both_go_on_after_it(pressed: str, taken: str, left: str) -> None:
    world = hall(study_lamp=lamp("study"), kitchen_lamp=lamp("kitchen"))
    async with virtual_house_of(world=world, config=config(), start="2026-01-01 17:50") as house:
        await house.run_until("17:55")
        await house.press("study_lamp", pressed)
        await house.run_until("18:01")
        assert (is_on(world, taken), is_on(world, left)) == (True, False)
        await house.run_until("18:11")
        assert not is_on(world, taken)
        assert not is_on(world, left)
        assert not is_on(world, "study_lamp")


@pytest.mark.parametrize("on", ["study_lamp", "desk_lamp", None])
async def test_of_several_options_the_first_that_holds_is_taken(on: str | None) -> None:
    world = hall(study_lamp=lamp("study"), desk_lamp=lamp("study"), kitchen_lamp=lamp("kitchen"), bar=lamp("kitchen"))
    option = {"if": ["desk lamp on"], "do": ["kitchen lamp on", "desk lamp off"], "else": ["bar on"]}
    first = {"if": ["name='study_lamp' on"], "do": ["hall lamp on", "desk lamp on"], "else": [option]}
    async with virtual_house_of(
        world=world, config=config(ROUTINE | {"do": [first, "study lamp off"]}), start="2026-01-01 17:50"
    ) as house:
        for one in (one for one in ("study_lamp", "desk_lamp") if one == on):
            await house.press(one, "on")
        await house.run_until("18:01")
        taken = [is_on(world, one) for one in ("hall_lamp", "kitchen_lamp", "bar")]
        assert taken == [on == "study_lamp", on == "desk_lamp", on is None]
        assert is_on(world, "desk_lamp") is (on == "study_lamp")


async def test_a_wait_in_the_other_way_goes_on_after_a_restart() -> None:
    world = hall(study_lamp=lamp("study"), kitchen_lamp=lamp("kitchen"))
    async with (
        virtual_house_of(world=world, config=config(), start="2026-01-01 17:50") as house,
        Node(house.runtime.graph, "owner") as owner,
    ):
        await house.run_until("18:05")
        await owner.create_client(ReloadApp, RELOAD_APP).call(ChangeAppRequest(app="choose"))
        await house.press("study_lamp", "on")  # the way was chosen before
        await house.run_until("18:09")
        assert is_on(world, "kitchen_lamp")
        await house.run_until("18:11")
        assert not is_on(world, "kitchen_lamp")
        assert not is_on(world, "study_lamp")
        (found,) = (await owner.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest())).routines
        assert [one.text for one in found.notes] == ["ran", "went on at 'wait 10m'"]
        assert found.steps == (
            "if study lamp on: hall lamp on; wait 10m; hall lamp off, else: kitchen lamp on; wait 10m; "
            "kitchen lamp off",
            "study lamp off",
        )
        assert read_routines(found.text, "its text")[0].table["do"] == [CHOICE, "study lamp off"]


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"if": ["study lamp onn"]}, "routines.choose.do.0: if.0: 'study lamp onn' names no state"),
        ({"do": ["hall lamp onn"]}, "routines.choose.do.0: do.0: 'hall lamp onn' is no step"),
        (
            {"do": [{"if": [], "do": ["wait 1m"]}]},
            "routines.choose.do.0: do.0: if: is empty; it should have at least 1 item",
        ),
        ({"else": [CHOICE | {"if": ["onn"]}]}, "routines.choose.do.0: else.0: if.0: 'onn'"),
        ({"do": []}, "routines.choose.do.0: do"),
        ({"otherwise": ["undo"]}, "routines.choose.do.0: otherwise: unknown key; known are if, do, else"),
    ],
)
async def test_a_mistake_in_a_choice_is_an_error_with_its_place(change: dict[str, object], problem: str) -> None:
    with pytest.raises(ConfigError) as error:
        async with virtual_house_of(world=hall(), config=config(ROUTINE | {"do": [CHOICE | change]})):
            pytest.fail("it starts")
    assert problem in str(error.value)
