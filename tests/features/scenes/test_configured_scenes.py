"""Scenes of the configuration: the tables [[scenes]]."""

import pytest
from tests.apps.houses import hall, lamp

from homebot.config import parse_config
from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.names import APPLY_SCENE, CHANGE_SCENE, LIST_SCENES
from homebot.devices.scene_messages import (
    ApplyScene,
    ApplySceneRequest,
    ChangeScene,
    ChangeSceneRequest,
    ChangeSceneResponse,
    ListScenes,
    SceneInfo,
    ScenesRequest,
)
from homebot.errors import ConfigError
from homebot.features.scenes.settings import read_scenes
from homebot.graph import Node
from homebot.testing import VirtualHouse, virtual_house_of

DINNER: dict[str, object] = {"name": "Dinner", "values": {"lamp in hall": "on, 60 %", "hull lamp": "on"}}


async def listed(house: VirtualHouse) -> tuple[SceneInfo, ...]:
    async with Node(house.runtime.graph, "person") as person:
        return (await person.create_client(ListScenes, LIST_SCENES).call(ScenesRequest())).scenes


async def apply(house: VirtualHouse, name: str) -> CommandDevicesResponse:
    async with Node(house.runtime.graph, "person") as person:
        request = ApplySceneRequest(name=name, issuer="client:local")
        return await person.create_client(ApplyScene, APPLY_SCENE).call(request, timeout=600)


async def change(house: VirtualHouse, **request: str) -> ChangeSceneResponse:
    async with Node(house.runtime.graph, "person") as person:
        asked = ChangeSceneRequest.model_validate(request)
        return await person.create_client(ChangeScene, CHANGE_SCENE).call(asked)


@pytest.mark.virtual_time
@pytest.mark.rooms("homeassistant")
async def test_a_scene_of_the_configuration_is_listed_applied_and_names_what_the_house_lacks() -> None:
    world = hall(study_lamp=lamp("study"))
    async with virtual_house_of(world=world, config={"scenes": [DINNER]}) as house:
        await house.run_until("07:00")
        (dinner,) = await listed(house)
        assert dinner.is_configured
        assert [(one.device, one.text) for one in dinner.parts] == [("hall_lamp", "on, 60 %")]
        assert [one.key for one in dinner.problems] == ["hull lamp"]
        applied = await apply(house, "dinner")
        outcomes = {one.name: one.result.outcome for one in applied.results}
        assert sorted(outcomes.values()) == ["confirmed", "gone"]
        assert "no device fits 'hull lamp'" in applied.message


@pytest.mark.virtual_time
@pytest.mark.rooms("homeassistant")
async def test_a_command_does_not_change_the_file_but_a_saved_scene_outranks_it() -> None:
    async with virtual_house_of(world=hall(), config={"scenes": [DINNER]}) as house:
        await house.run_until("07:00")
        refused = await change(house, name="Dinner", change="remove")
        assert refused.message == "the scene Dinner is in the configuration; change it there, and `homebot reload`"
        assert (await change(house, name="Dinner", change="save")).success
        (dinner,) = await listed(house)
        assert not dinner.is_configured
        assert (await change(house, name="Dinner", change="remove")).success
        (dinner,) = await listed(house)
        assert dinner.is_configured


@pytest.mark.virtual_time
@pytest.mark.rooms("homeassistant")
async def test_a_renamed_or_new_scene_hides_none_of_the_configuration() -> None:
    async with virtual_house_of(world=hall(), config={"scenes": [DINNER]}) as house:
        await house.run_until("07:00")
        assert (await change(house, name="Film", change="save", target="hall lamp")).success
        refused = await change(house, name="Film", change="rename", target="dinner")
        assert refused.message == ("the configuration has a scene 'dinner', which this would hide; choose another name")
        again = await change(house, name="dinner", change="save", target="hall lamp")
        assert again.message == refused.message
        assert [(one.name, one.is_configured) for one in await listed(house)] == [("Dinner", True), ("Film", False)]


@pytest.mark.parametrize(
    ("scenes", "problem"),
    [
        ([{"values": {"lamp": "on"}}], "scenes.0.name"),
        ([{"name": "A", "values": {}}], "scenes.0.values"),
        ([{"name": "A", "values": {}}], "scenes.0.values: is empty; it should have at least 1 item"),
        ([{"name": "A", "values": {"lamp": ""}}], "scenes.0.values.lamp"),
        ([{"name": "A", "values": {"lock": "unlock, code 1234"}}], "scenes.0.values.lock: no code is kept"),
        ([{"name": "a\nb", "values": {"lamp": "on"}}], "scenes.0.name"),
        ([{"name": "A", "values": {"lamp": "on"}}, {"name": "a", "values": {"lamp": "on"}}], "scenes.1.name"),
        ([{"name": "A", "values": {"lamp": "on"}, "at": "x"}], "scenes.0.at: unknown key"),
    ],
)
def test_a_mistake_is_named_with_its_key(scenes: list[dict[str, object]], problem: str) -> None:
    config = parse_config({"scenes": scenes}, "homebot.toml")
    with pytest.raises(ConfigError, match=problem):
        read_scenes(config)
