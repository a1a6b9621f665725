"""What clients of the door may do with scenes."""

import anyio
import pytest
from tests.control.conftest import Home
from tests.features.scenes.conftest import Scenes

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.devices.client_rights import LOCAL_RIGHTS
from homebot.devices.own_services import right_to_call
from homebot.devices.robot_owners import RobotOwners
from homebot.devices.scene_messages import ApplySceneRequest
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.rights import Right


@pytest.mark.parametrize(
    ("service", "right"),
    [("/scenes/list", Right.READ), ("/scenes/apply", Right.ACT), ("/scenes/change", Right.MANAGE)],
)
def test_a_client_that_only_reads_lists_scenes_and_applies_or_changes_none(service: str, right: Right) -> None:
    assert right_to_call(service) is right


def test_a_client_applies_a_scene_in_its_own_name_and_says_not_what_led_to_it() -> None:
    client = ClientAccess("tablet", LOCAL_RIGHTS, RobotOwners())
    forged = {"name": "Film", "issuer": "/app", "scope": ["act: all"], "trigger": {"kind": "report", "scene": "Alarm"}}
    assert client.stamped(ApplySceneRequest, forged) == {
        "name": "Film",
        "issuer": "client:tablet",
        "scope": list(LOCAL_RIGHTS.act_scope),
        "trigger": {},
    }


@pytest.mark.virtual_time
async def test_the_rights_of_a_client_count_for_each_part(home: Home, scenes: Scenes) -> None:
    for key, area in (("lamp", "hall"), ("shelf", "study")):
        home.put(key, "light", "on_off", area=area)
        await home.report(key, "on_off", False)
    await scenes.change(name="Bright", change="save", values=[{"key": "light", "value": "on"}])
    answer = await scenes.apply("Bright", issuer="client:guest", scope=["act: light in hall"])
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Lamp", "confirmed"), ("Shelf", "refused")]
    assert [one.key for one in home.commands] == ["lamp"]


@pytest.mark.virtual_time
async def test_an_undo_that_was_refused_can_still_be_made_by_somebody_else(home: Home, scenes: Scenes) -> None:
    for key, area in (("lamp", "hall"), ("shelf", "study")):
        home.put(key, "light", "on_off", area=area)
        await home.report(key, "on_off", False)
    await scenes.change(name="Bright", change="save", values=[{"key": "light", "value": "on"}])
    assert (await scenes.apply("Bright", scope=["act: all"])).success
    answer = await scenes.apply("Bright", undo=True, issuer="client:guest", scope=["act: light in hall"])
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Lamp", "confirmed"), ("Shelf", "refused")]
    assert (await scenes.shown("Bright")).can_undo
    answer = await scenes.apply("Bright", undo=True, scope=["act: all"])
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Shelf", "confirmed")]
    assert not (await scenes.shown("Bright")).can_undo


@pytest.mark.virtual_time
async def test_what_always_asks_is_asked_for_unless_the_person_at_the_client_has_agreed(
    home: Home, scenes: Scenes
) -> None:
    home.put("door", "door_lock", "lock")
    await home.report("door", "lock", "locked")
    await scenes.change(name="Open", change="save", values=[{"key": "door", "value": "unlock"}])
    everything = {"scope": ["act: all"]}
    asked = await scenes.apply("Open", **everything)
    assert asked.results[0].result.policy == "ask"
    assert "nobody answered" in asked.message
    agreed = await scenes.apply("Open", agreed=True, **everything)
    assert agreed.outcome == "confirmed"


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    ("scope", "policy"), [("act: all", "ask"), ("act: scene or light", "rights"), ("act: scene or lock", "ask")]
)
async def test_a_scene_of_unknown_values_is_judged_by_its_parts_that_always_ask(
    home: Home, scenes: Scenes, scope: str, policy: str
) -> None:
    """It may unlock the door."""
    await native_scene(home)
    answer = await scenes.apply("Film", issuer="client:guest", scope=[scope])
    assert (answer.results[0].result.policy, home.commands) == (policy, [])
    agreed = await scenes.apply("Film", issuer="client:guest", scope=[scope], agreed=True)
    assert agreed.success is (policy == "ask")


@pytest.mark.virtual_time
async def test_a_command_to_a_scene_needs_the_right_to_its_parts_that_always_ask(home: Home, scenes: Scenes) -> None:
    await native_scene(home)
    answer = await scenes.apply("Film", issuer="client:guest", scope=["act: scene"], agreed=True)
    assert "its member door is refused it: client:guest may not command door" in answer.message.casefold()
    assert home.commands == []


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    ("other", "policy"), [("shelf", ""), ("cupboard", "rights"), ("attic", "rights"), ("door", "rights")]
)
async def test_a_right_to_all_parts_of_a_scene_is_one_to_the_scene(
    home: Home, scenes: Scenes, other: str, policy: str
) -> None:
    """The cupboard is in another room, nobody knows the attic, and the door is no lamp."""
    await native_scene(home, "lamp", other)
    answer = await scenes.apply("Film", issuer="client:guest", scope=["act: light in hall"])
    assert [(one.key, one.capability) for one in home.commands] == [("bridge", "scene")] * (not policy)
    assert answer.results[0].result.policy == policy


async def native_scene(home: Home, *members: str) -> None:
    """Put a scene of a lamp and a lock, or of *members*, of which the values are unknown."""
    kinds = dict.fromkeys(("lamp", "shelf", "cupboard"), ("light", "on_off")) | {"door": ("door_lock", "lock")}
    for key, (kind, capability) in kinds.items():
        part = simple_part(kind, settable=(capability,))
        area = "study" if key == "cupboard" else "hall"
        known = GatewayDevice(key, key, (part,), identifiers=(f"id:{key}",), area=area)
        home.gateway.devices.put(known, "it was found")
        await home.report(key, capability, "locked" if key == "door" else False)
    film = simple_part("x_scene", settable=("scene",))
    mute = tuple(one.model_copy(update={"readable": False}) for one in film.capabilities)
    names = tuple(f"id:{key}" for key in members or ("lamp", "door"))
    film = film.model_copy(update={"name": "Film", "capabilities": mute, "members": names})
    home.gateway.devices.put(GatewayDevice("bridge", "Bridge", (film,)), "it was found")
    await anyio.sleep(120)
    home.commands.clear()


@pytest.mark.virtual_time
async def test_an_app_cannot_agree_for_a_person(home: Home, scenes: Scenes) -> None:
    home.put("door", "door_lock", "lock")
    await home.report("door", "lock", "locked")
    await scenes.change(name="Open", change="save", values=[{"key": "door", "value": "unlock"}])
    answer = await scenes.apply("Open", issuer="/app", agreed=True)
    assert answer.outcome == "refused"
    assert home.commands == []
