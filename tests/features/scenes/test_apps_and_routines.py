"""Scenes from commands in words, routines and apps, in a simulated flat in virtual time."""

import anyio
import pytest
from tests.apps.houses import hall, is_on, lamp

from homebot import App
from homebot.devices import KeyValue
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest, ListRoutines, RoutinesRequest
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest, CommandDevicesResponse
from homebot.devices.names import CHANGE_ROUTINE, CHANGE_SCENE, COMMAND_DEVICES, LIST_ROUTINES
from homebot.devices.scene_client import SceneOutcome
from homebot.devices.scene_messages import ChangeScene, ChangeSceneRequest
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.testing import VirtualHouse, virtual_house_of
from homebot.words.steps import Do, read_step

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


class Evening(App):
    """Applies a scene when it is asked to."""

    async def run(self) -> None:
        await anyio.sleep_forever()

    async def film(self) -> SceneOutcome:
        return await self.scenes.apply("film")


async def save(house: VirtualHouse, name: str, **values: str) -> None:
    async with Node(house.runtime.graph, "person") as person:
        given = tuple(KeyValue(key=key, value=value) for key, value in values.items())
        request = ChangeSceneRequest(name=name, change="save", values=given)
        answer = await person.create_client(ChangeScene, CHANGE_SCENE).call(request)
    assert answer.success, answer.message


async def do(house: VirtualHouse, target: str, word: str) -> CommandDevicesResponse:
    async with Node(house.runtime.graph, "person") as person:
        request = CommandDevicesRequest(target=target, command=word, issuer="client:local")
        return await person.create_client(CommandDevices, COMMAND_DEVICES).call(request, timeout=600)


async def test_a_command_in_words_applies_and_undoes_a_scene() -> None:
    world = hall(study_lamp=lamp("study"))
    async with virtual_house_of(world=world) as house:
        await house.run_until("07:00")
        await save(house, "Film", hall_lamp="on, 20 %", study_lamp="on")
        applied = await do(house, "Scene film", "on")
        assert [one.result.outcome for one in applied.results] == ["confirmed", "confirmed"]
        assert is_on(world, "hall_lamp")
        undone = await do(house, "scene Film", "undo")
        assert [one.result.outcome for one in undone.results] == ["confirmed", "confirmed"]
        assert not is_on(world, "hall_lamp")
        unknown = await do(house, "scene Fim", "on")
        assert unknown.message == "there is no scene 'Fim'; did you mean Film?"


@pytest.mark.rooms("routines")
async def test_a_step_of_a_routine_applies_a_scene_and_its_undo_brings_back_what_was_before() -> None:
    assert read_step("scene Film night") == Do("scene Film night", "scene Film night", "apply")
    slowly = read_step("scene Film, over 5s")
    assert slowly == Do("scene Film, over 5s", "scene Film", "apply", transition=5.0)
    world = hall(study_lamp=lamp("study"))
    routine = {"name": "Evening", "when": ["18:30"], "do": ["scene Film", "wait 10m", "undo"]}
    async with virtual_house_of(world=world, config={"routines": [routine], "home": {"zone": "UTC"}}) as house:
        await house.run_until("07:00")
        await save(house, "Film", hall_lamp="on, 20 %", study_lamp="on")
        await house.run_until("18:31")
        assert is_on(world, "hall_lamp")
        assert is_on(world, "study_lamp")
        await house.run_until("18:41")
        assert not is_on(world, "hall_lamp")
        assert not is_on(world, "study_lamp")


@pytest.mark.rooms("routines")
async def test_a_scene_that_is_renamed_is_so_in_its_routines_and_others_are_named() -> None:
    configured = {"name": "Late", "when": ["22:30"], "do": ["scene film, over 5s"]}
    kept = """[[routines]]
name = "Evening"
when = ["18:30"]
do = ["scene Film", "wait 10m", 'scene film, over 5s', "scene 'Film'", 'scene "film", over 5s',
    "scene \\"Film\\"", "scene Filmed"]
"""
    async with virtual_house_of(world=hall(), config={"routines": [configured], "home": {"zone": "UTC"}}) as house:
        await house.run_until("07:00")
        await save(house, "Film", hall_lamp="on, 20 %")
        async with Node(house.runtime.graph, "person") as person:
            change = person.create_client(ChangeRoutine, CHANGE_ROUTINE)
            assert (await change.call(ChangeRoutineRequest(change="new", text=kept))).success
            request = ChangeSceneRequest(name="Film", change="rename", target="Cinema night")
            answer = await person.create_client(ChangeScene, CHANGE_SCENE).call(request)
            assert answer.success
            assert answer.message == "the routine Late still applies Film; change it there"
            routines = (await person.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest())).routines
        (evening,) = (one for one in routines if one.is_kept)
        renamed, faded = "scene Cinema night", "scene Cinema night, over 5s"
        assert evening.steps == (renamed, "wait 10m", faded, renamed, faded, renamed, "scene Filmed")


async def test_an_app_applies_a_scene_and_gets_the_outcome_of_each_part() -> None:
    world = hall()
    async with virtual_house_of(f"{__name__}:Evening", world=world) as house:
        await house.run_until("07:00")
        (app,) = (one for one in house.runtime.app_host.running.values() if isinstance(one, Evening))
        with pytest.raises(UsageError, match="there is no scene 'film'"):
            await app.film()
        await save(house, "Film", hall_lamp="on, 20 %")
        outcome = await app.film()
        assert outcome.succeeded
        assert [one.kind for one in outcome.parts.values()] == ["confirmed"]
        assert {one.name for one in await app.scenes.list()} == {"Film"}
        assert (await app.scenes.undo("Film")).succeeded
        assert not is_on(world, "hall_lamp")


@pytest.mark.rooms("routines")
async def test_a_routine_that_applies_a_scene_is_checked_by_its_values() -> None:
    """At one time one turns the lamp off, and the scene of another turns it on."""
    world = hall()
    routines = [
        {"name": "Film", "when": ["18:30"], "do": ["scene Film"]},
        {"name": "Dark", "when": ["18:30"], "do": ["hall lamp off"]},
    ]
    async with virtual_house_of(world=world, config={"routines": routines, "home": {"zone": "UTC"}}) as house:
        await house.run_until("07:00")
        await save(house, "Film", hall_lamp="on, 20 %")
        async with Node(house.runtime.graph, "person") as person:
            request = RoutinesRequest(check=True)
            answer = await person.create_client(ListRoutines, LIST_ROUTINES).call(request)
    assert any("'scene Film'" in hint for one in answer.routines for hint in one.hints)
