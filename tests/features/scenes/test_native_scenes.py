"""Scenes that a bridge or device keeps: one message, and a proof of each part where the values are known."""

from collections.abc import Mapping

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, hold_request
from tests.features.scenes.conftest import Scenes

from homebot.devices.gateway_messages import Command
from homebot.devices.part import Part, SceneValue
from homebot.devices.value import PlainValue, Value
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time

FILM: Mapping[str, Mapping[str, PlainValue]] = {
    "lamp": {"on_off": True, "level": 20.0},
    "shelf": {"on_off": False},
}


def scene_part(values: Mapping[str, Mapping[str, PlainValue]], name: str = "Film") -> Part:
    told = [
        SceneValue(member=f"id:{key}", capability=capability, value=Value.of(value))
        for key, settings in values.items()
        for capability, value in settings.items()
    ]
    part = simple_part("x_scene", settable=("scene",))
    mute = tuple(one.model_copy(update={"readable": False}) for one in part.capabilities)
    members = ("id:lamp", "id:shelf")
    return part.model_copy(update={"name": name, "capabilities": mute, "members": members, "values": tuple(told)})


def recall(*deaf: str) -> Behaviour:
    """Return a bridge whose recall does not reach some lamps."""

    async def tell(home: Home, _: Command) -> None:
        for key in FILM.keys() - set(deaf):
            for capability, value in FILM[key].items():
                home.later(0.2, key, capability, value)

    return tell


async def living(home: Home, *scenes: Part, deaf: tuple[str, ...] = ()) -> None:
    """Put two lamps, and a bridge that keeps *scenes* of them, each in a device with a room."""
    for key in FILM:
        part = simple_part("light", settable=("on_off", "level"))
        home.gateway.devices.put(GatewayDevice(key, key.title(), (part,), identifiers=(f"id:{key}",)), "it was found")
        await home.report(key, "on_off", key == "shelf")
        await home.report(key, "level", 80.0)
    for number, one in enumerate(scenes):
        key = f"bridge{number}"
        home.gateway.devices.put(GatewayDevice(key, key.title(), (one,), area=f"room {number}"), "it was found")
        home.behaviours[key] = recall(*deaf)
    await anyio.sleep(120)


def sent(home: Home) -> list[tuple[str, str]]:
    return [(one.key, one.capability) for one in home.commands]


async def test_a_native_scene_is_listed_with_its_values(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM))
    shown = await scenes.shown("film")
    assert (shown.is_native, shown.area, shown.id) == (True, "room 0", "bridge0")
    assert await scenes.values("film") == {"Lamp": "on, 20 %", "Shelf": "off"}


async def test_one_message_recalls_it_and_each_part_proves_it(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM))
    answer = await scenes.apply("Film")
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Lamp", "confirmed"), ("Shelf", "confirmed")]
    assert sent(home) == [("bridge0", "scene")]
    entries = (await home.read()).entries
    assert [one.cause for one in entries if one.kind in {"reported", "changed"}].count("command") == 3


async def test_a_scene_of_one_lamp_is_recalled_by_one_message_too(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part({"lamp": FILM["lamp"]}), deaf=("shelf",))
    assert (await scenes.apply("Film")).outcome == "confirmed"
    assert sent(home) == [("bridge0", "scene")]


async def test_a_part_that_did_not_follow_gets_a_command_of_its_own(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM), deaf=("lamp",))
    answer = await scenes.apply("Film")
    assert answer.success, answer.message
    assert sent(home) == [("bridge0", "scene"), ("lamp", "level"), ("lamp", "on_off")]


async def test_where_a_lease_holds_a_part_the_scene_is_not_recalled(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM))
    await home.hold(hold_request("lamp", "on_off", False))
    home.commands.clear()
    answer = await scenes.apply("Film", issuer="client:other")
    assert ("bridge0", "scene") not in sent(home)
    assert [one.result.outcome for one in answer.results] == ["refused", "confirmed"]


async def test_an_own_scene_with_the_same_values_is_recalled_natively(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM))
    values = [{"key": "lamp", "value": "on, 20 %"}, {"key": "shelf", "value": "off"}]
    await scenes.change(name="Kino", change="save", values=values)
    assert (await scenes.apply("Kino")).success
    assert sent(home) == [("bridge0", "scene")]


async def test_a_scene_whose_values_are_unknown_is_recalled_and_undone(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part({}))
    assert await scenes.values("Film") == {"Lamp": "", "Shelf": ""}
    answer = await scenes.apply("Film", scope=["act: all"])
    assert [(one.device, one.result.outcome) for one in answer.results] == [("bridge0", "confirmed")]
    await anyio.sleep(5)
    causes = [one.cause for one in (await home.read()).entries if one.kind in {"reported", "changed"}]
    assert "person" not in causes
    undone = await scenes.apply("Film", undo=True)
    assert [(one.name, one.result.outcome) for one in undone.results] == [("Lamp", "confirmed"), ("Shelf", "confirmed")]


async def test_no_scene_of_the_owner_hides_one_that_a_bridge_keeps(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM))
    values = [{"key": "lamp", "value": "on"}]
    problem = "bridge0 keeps a scene 'Film', which this would hide; choose another name"
    assert (await scenes.change(name="film", change="save", values=values)).message == problem
    assert (await scenes.change(name="Kino", change="save", values=values)).success
    assert (await scenes.change(name="Kino", change="rename", target="Film")).message == problem


async def test_scenes_of_one_name_in_several_rooms_are_told_apart_by_the_room(home: Home, scenes: Scenes) -> None:
    await living(home, scene_part(FILM), scene_part({}))
    answer = await scenes.apply("Film")
    assert answer.message == "2 scenes are called 'Film'; name one: 'Film in room 0' or 'Film in room 1'"
    assert (await scenes.apply("film in room 0")).success


async def test_a_scene_that_names_its_parts_by_their_ids_alone_has_them(home: Home, scenes: Scenes) -> None:
    """As Home Assistant does, whose entities have ids that are unique in it."""
    for key in FILM:
        part = simple_part("light", settable=("on_off",)).model_copy(update={"id": f"light_{key}"})
        home.gateway.devices.put(GatewayDevice(key, key.title(), (part,)), "it was found")
    part = scene_part({}).model_copy(update={"id": "scene_film", "members": ("#light_lamp", "#light_gone")})
    home.gateway.devices.put(GatewayDevice("film", "Film", (part,)), "it was found")
    assert await scenes.values("Film") == {"Lamp": ""}


async def test_a_device_that_keeps_a_scene_of_its_own_is_its_part(home: Home, scenes: Scenes) -> None:
    """As a Zigbee lamp does."""
    lamp = simple_part("light", settable=("on_off",)).model_copy(update={"id": "light"})
    scene = scene_part({}).model_copy(update={"id": "scene_7", "members": ()})
    home.gateway.devices.put(GatewayDevice("lamp", "Lamp", (lamp, scene)), "it was found")
    assert await scenes.values("Film") == {"Lamp": ""}
    answer = await scenes.apply("Film", transition=2.0)
    assert answer.success, answer.message
    assert [(one.part, one.capability, one.transition) for one in home.commands] == [("scene_7", "scene", 2.0)]
