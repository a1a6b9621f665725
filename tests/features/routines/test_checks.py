"""What homebot says of routines that cannot work in the house as it is."""

import json
from collections.abc import Mapping, Sequence

import pytest
from tests.apps.houses import hall, lamp, motion
from tests.recorded_house import HOUSE

from homebot.devices.app_messages import ListRoutines, RoutinesRequest
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import LIST_ROUTINES, RUNTIME_HEALTH
from homebot.features.routines.checks import asked_about
from homebot.features.routines.settings import RoutineSettings
from homebot.graph import Node
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

DAILY: dict[str, object] = {"name": "A", "when": ["18:00"], "do": ["hall lamp on"]}


ANNOUNCED: dict[str, object] = {
    "homeassistant/switch/heater/config": {
        "unique_id": "heater",
        "name": "heater",
        "command_topic": "heater/set",
        "state_topic": "heater/state",
        "device_class": "outlet",
    },
    "homeassistant/event/button/config": {
        "unique_id": "button",
        "name": "hall button",
        "state_topic": "button/events",
        "device_class": "button",
        "event_types": ["single", "double"],
    },
}


async def hints(*routines: Mapping[str, object]) -> Mapping[str, Sequence[str]]:
    """What is said of *routines* in a flat with lamps in hall and study, a plug, a button, and motion in the hall."""
    world = hall(study_lamp=lamp("study"))
    tables = {"routines": list(routines), "home": {"zone": "UTC", "latitude": 52.5, "longitude": 13.4}}
    async with virtual_house_of(world=world, config=tables) as house, Node(house.runtime.graph, "owner") as owner:
        for topic, announced in ANNOUNCED.items():  # the simulated house has no plugs and no buttons
            await house.says(topic, json.dumps(announced))
        await house.run_for("1m")
        answer = await owner.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest(check=True))
        for one in answer.routines:  # the same, asked for one alone
            ((_, keeper),) = house.runtime.app_host.keepers()
            alone = await keeper.hints([one.name])
            assert sorted(alone.get(one.name, ())) == sorted(one.hints)
        troubles = (await owner.create_client(GetHealth, RUNTIME_HEALTH).call(HealthRequest())).troubles
    found = {one.name: one.hints for one in answer.routines if one.hints}
    assert [*troubles] == [f"the routine {name}: {hint}" for name, said in found.items() for hint in said]
    return found


async def test_a_step_for_which_the_routine_has_no_right_is_said_before_it_is_due() -> None:
    found = await hints(DAILY | {"do": ["heater on", "hall lamp on"], "act": "light"})
    assert found == {"A": ("'heater on' is refused: /a may not command heater, only: act: light",)}


async def test_nothing_is_said_of_routines_that_work() -> None:
    assert not await hints(
        {"name": "Motion", "when": ["hall motion occupied"], "if": ["study lamp off"], "do": ["hall lamp on, 20 %"]},
        {
            "name": "Button",
            "when": ["hall button press"],
            "do": ["lights off", "wait until hall motion clear, at most 1h"],
        },
        {"name": "Toggle", "when": ["18:00"], "do": ["heater toggle", "lamps that are on off"]},
    )


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"when": ["hall_lam on"]}, "'hall_lam on': no device has the word 'lam'; similar: hall lamp"),
        ({"do": ["hull lamp on"]}, "'hull lamp on': no device fits 'hull lamp'; did you mean hall_lamp?"),
        ({"do": ["scene Film"]}, "'scene Film': there is no scene 'Film'; `homebot scene list` shows them"),
        ({"do": ["lights in garage off"]}, "'lights in garage off': "),
        ({"do": ["heater 40 %"]}, "'heater 40 %': heater: this part takes on, off"),
        ({"do": ["hall lamp closed"]}, "'hall lamp closed': hall_lamp: "),
        ({"do": ["hall motion on"]}, "'hall motion on': "),
        ({"do": [{"if": ["attic lamp on"], "do": ["hall lamp on"]}]}, "'attic lamp on': "),
        ({"do": [{"if": ["hall lamp on"], "do": ["attic lamp on"]}]}, "'attic lamp on': "),
        ({"do": ["hall lamp on", "wait until attic motion clear, at most 1h"]}, "'wait until attic motion clear, "),
        ({"do": ["robot go to hall"]}, "'robot go to hall': "),
        ({"do": ["attic lamp dim while hall button single"]}, "'attic lamp dim while hall button single': "),
        ({"do": ["hall lamp dim while attic button single"]}, "'attic button press single': "),
        ({"when": ["study motion occupied"]}, "'study motion occupied': "),
        ({"when": ["temperature in hall below 18 °C"]}, "'temperature in hall below 18 °C': "),
        ({"when": ["hall button press tripple"]}, "'hall button press tripple': it has no event 'tripple'"),
        ({"when": ["hall button#left press"]}, "'hall button#left press': it has no button 'left'; it has "),
        ({"when": ["Anna arrives"]}, "'Anna arrives': "),
        ({"when": ["robot arrives in mars"]}, "'robot arrives in mars': there is no room 'mars'; rooms are "),
        ({"if": ["nobody is home"]}, "'nobody is home': "),
        ({"if": ["nobody in studdy"]}, "'nobody in studdy': "),
    ],
)
async def test_a_name_or_value_that_the_house_lacks_is_named(change: dict[str, object], problem: str) -> None:
    found = await hints(DAILY | change)
    assert [one[: len(problem)] for one in found["A"]] == [problem], found


def test_a_trial_knows_the_devices_that_a_routine_asks_about_or_commands() -> None:
    steps = ["wait until front door open, at most 1m", "bath heating 20 °C", "hall lamp two dim while hall button hold"]
    routine = RoutineSettings.model_validate({"name": "A", "when": ["Anna arrives"], "do": steps})
    known = {one.id for one in HOUSE if asked_about([routine])(one)}
    assert known == {"anna", "front_door", "bath_heating", "hall_lamp_two", "hall_button"}


async def test_a_routine_that_starts_itself_through_others_is_named() -> None:
    found = await hints(
        {"name": "A", "when": ["hall lamp on"], "do": ["wait 1s", "study lamp on, 20 %"]},
        {"name": "B", "when": ["study lamp on"], "do": ["heater on"]},
        {"name": "C", "when": ["heater on"], "do": ["lights in hall on"]},
        {"name": "D", "when": ["heater on"], "do": ["study lamp off"]},
    )
    assert found["A"] == (
        "it would start itself: 'study lamp on, 20 %' of A starts B; 'heater on' of B starts C; "
        "'lights in hall on' of C starts A",
    )
    assert [*found] == ["A", "B", "C"]


async def test_two_that_toggle_each_other_are_named() -> None:
    """But not one that toggles what starts it: then it is no longer so."""
    found = await hints(
        {"name": "A", "when": ["hall lamp on"], "do": ["study lamp toggle"]},
        {"name": "B", "when": ["study lamp off"], "do": ["hall lamp toggle"]},
        {"name": "C", "when": ["heater on"], "do": ["heater toggle"]},
    )
    assert found["A"] == ("it would start itself: 'study lamp toggle' of A starts B; 'hall lamp toggle' of B starts A",)
    assert [*found] == ["A", "B"]


async def test_a_routine_that_starts_itself_by_a_query_is_named() -> None:
    found = await hints({"name": "A", "when": ["light in hall on"], "do": ["hall lamp 40 %"]})
    assert found["A"] == ("it would start itself: 'hall lamp 40 %' of A starts A",)


async def test_the_routines_of_a_device_are_those_that_command_it() -> None:
    tables = {
        "routines": [DAILY, DAILY | {"name": "B", "do": ["lights off"]}, DAILY | {"name": "C", "do": ["wait 1m"]}]
    }
    world = hall(study_lamp=lamp("study"))
    async with virtual_house_of(world=world, config=tables) as house, Node(house.runtime.graph, "owner") as owner:
        await house.run_for("1m")
        listing = owner.create_client(ListRoutines, LIST_ROUTINES)
        found = (await listing.call(RoutinesRequest(device="study_lamp"))).routines
        assert [one.name for one in found] == ["B"]
        found = (await listing.call(RoutinesRequest(device="hall_lamp"))).routines
        assert [one.name for one in found] == ["A", "B"]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"when": ["18:00"]}, {"when": ["18:00:00 on weekdays"]}),
        ({"when": ["hall motion occupied"]}, {"when": ["23:00", "hall motion occupied"]}),
        ({"when": ["hall button press"]}, {"when": ["hall button press double"]}),
        ({"when": ["sunset - 30m"], "if": ["on weekdays"]}, {"when": ["sunset - 30m"], "if": ["after 10:00"]}),
    ],
)
async def test_two_that_fight_over_a_part_are_named(one: dict[str, object], other: dict[str, object]) -> None:
    found = await hints(
        {"name": "A", "do": ["hall lamp on, 20 %"], **one}, {"name": "B", "do": ["lights in hall off"], **other}
    )
    assert "it fights with B over hall_lamp: 'hall lamp on, 20 %' here and 'lights in hall off' there" in found["A"]
    assert "it fights with A over hall_lamp: 'lights in hall off' here and 'hall lamp on, 20 %' there" in found["B"]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"when": ["18:00"]}, {"when": ["18:01"]}),
        ({"when": ["18:00 on weekdays"]}, {"when": ["18:00 on weekends"]}),
        ({"when": ["hall motion occupied"]}, {"when": ["hall motion clear"]}),
        ({"when": ["hall button press single"]}, {"when": ["hall button press double"]}),
        ({"when": ["18:00"], "if": ["sun is up"]}, {"when": ["18:00"], "if": ["sun is down"]}),
        (
            {"when": ["hall motion occupied"], "if": ["before 9:00"]},
            {"when": ["hall motion occupied"], "if": ["after 9:00"]},
        ),
        ({"when": ["18:00"], "if": ["study lamp on"]}, {"when": ["18:00"], "if": ["not study lamp on"]}),
        ({"when": ["18:00"], "do": ["wait 1h", "hall lamp on"]}, {"when": ["18:00"]}),
        ({"when": ["18:00"]}, {"when": ["18:00"], "enabled": False}),
        ({"when": ["18:00"]}, {"when": ["18:00"], "do": ["study lamp off"]}),
    ],
)
async def test_two_that_never_meet_do_not_fight(one: dict[str, object], other: dict[str, object]) -> None:
    found = await hints(
        {"name": "A", "do": ["hall lamp on, 20 %"], **one}, {"name": "B", "do": ["lights in hall off"], **other}
    )
    assert not [hint for said in found.values() for hint in said if "fights" in hint]


async def test_a_state_that_begins_with_the_name_of_a_device_and_means_others_too_is_told() -> None:
    """Without a room the name means that device alone, as in a command."""
    world = hall(lamp_1=lamp("study"), lamp_2=lamp("kitchen"), spot_2=lamp("kitchen"))
    said = [{"name": "A", "when": ["lamp_1 on", "lamp 2 off", "lamp 2 off in kitchen"], "do": ["lamp_1 off"]}]
    async with (
        virtual_house_of(world=world, config={"routines": said}) as house,
        Node(house.runtime.graph, "o") as node,
    ):
        await house.run_for("1m")
        answer = await node.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest(check=True))
    assert answer.routines[0].hints == (
        "'lamp 2 off in kitchen': this is about spot_2 as well; for lamp_2 alone begin with name=\"lamp_2\"",
    )


async def test_the_rest_of_one_of_several_sensors_is_told_with_the_text_for_all() -> None:
    world = hall(hall_eye=motion("hall"))
    when = ["motion in hall clear for 5m", "no motion in hall for 5m", "hall lamp off for 5m"]
    said = [{"name": "A", "when": when, "do": ["notify quiet"]}]
    async with (
        virtual_house_of(world=world, config={"routines": said, "notify": {}}) as house,
        Node(house.runtime.graph, "o") as node,
    ):
        await house.run_for("1m")
        answer = await node.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest(check=True))
    assert answer.routines[0].hints == (
        "'motion in hall clear for 5m': one of hall_eye or hall_motion suffices; for all of them write "
        "'no motion in hall occupied for 5m'",
    )
