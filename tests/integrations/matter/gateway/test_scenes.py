"""The scenes that Matter's devices keep: read with their values, recalled, and read again when others are stored."""

import pytest
from tests.gateways.watched_gateway import reading, receive
from tests.integrations.matter.gateway.test_gateway import house
from tests.integrations.matter.gateway.test_node import COVER, LAMP, node

from homebot.devices.gateway_messages import Command
from homebot.devices.part import Part
from homebot.devices.value import PlainValue, Value
from homebot.house.dialect import DeviceState
from homebot.integrations.matter.formats.scenes import groups_at, read_scene, scene_count, scene_numbers
from homebot.integrations.matter.gateway.node import NodeDevice

GROUPS = {"0/63/1": [{"1": 7, "2": [1, 2], "3": "Hall"}, {"1": 8, "2": [2]}, {"1": None}, "x"]}


def pairs(**values: int) -> list[object]:
    """Return attribute values of one cluster, as ``a7=250``."""
    none = dict.fromkeys(("valueSigned8", "valueUnsigned32"))
    return [{"attributeID": int(key[1:]), **none, "valueUnsigned16": value} for key, value in values.items()]


def sets(**clusters: list[object]) -> list[object]:
    return [{"clusterID": int(key[1:]), "attributeValueList": listed} for key, listed in clusters.items()]


def with_scene(attributes: dict[str, object], fields: object, group: int = 0, name: str = "Film") -> NodeDevice:
    one = node(attributes)
    answer = {"status": 0, "sceneName": name, "extensionFieldSetStructs": fields}
    one.endpoints[1].scenes = (read_scene(group, 3, answer),)
    return one.devices()[0]


def scene_of(device: NodeDevice) -> Part:
    return next(one for one in device.device.parts if one.service_type == "x_scene")


def values(part: Part) -> dict[str, PlainValue]:
    return {one.capability: one.value.plain() for one in part.values}


@pytest.mark.parametrize(
    ("attributes", "fields", "found"),
    [
        (LAMP, sets(c6=pairs(a0=1), c8=pairs(a0=51)), {"on_off": True, "level": 20.08}),
        (LAMP, sets(c6=pairs(a0=0), c8=pairs(a0=51)), {"on_off": False}),
        (
            LAMP,
            sets(c6=pairs(a0=1), c768=pairs(a7=200, a16385=2)),
            {"on_off": True, "color_temperature": 5000.0},
        ),
        (LAMP, sets(c6=pairs(a0=1), c768=pairs(a16385=0, a1=254, a0=0)), {"on_off": True, "color": (0.0, 100.0)}),
        (COVER, sets(c258=pairs(a14=10_000)), {"position": 0.0}),
        (LAMP, sets(c6=pairs(a0=1), c1234=pairs(a0=1)), {}),
        (LAMP, sets(c6=pairs(a0=1), c8=pairs(a0=255)), {}),
        (LAMP, [], {}),
        (LAMP, "rubbish", {}),
        (LAMP, [{"clusterID": "x", "attributeValueList": [{}, 3]}, 4], {}),
    ],
)
def test_the_values_of_a_scene_are_known_if_all_of_them_are(
    attributes: dict[str, object], fields: object, found: dict[str, PlainValue]
) -> None:
    part = scene_of(with_scene(attributes, fields))
    assert values(part) == found
    assert part.members == ("id:SN-7700#1",)


def test_fields_are_found_by_number_and_in_the_spelling_of_matter_js() -> None:
    numbered = [{"0": 6, "1": [{"0": 0, "1": 1}]}]
    assert values(scene_of(with_scene(LAMP, numbered))) == {"on_off": True}
    spelled = [{"clusterId": 6, "attributeValueList": [{"attributeId": 0, "valueUnsigned8": 1}]}]
    assert values(scene_of(with_scene(LAMP, spelled))) == {"on_off": True}


def test_a_scene_has_its_name_and_number_and_is_recalled_with_a_transition() -> None:
    device = with_scene(LAMP, [], group=7, name="")
    part = scene_of(device)
    assert (part.id, part.name) == ("1-scene-7-3", "Scene 3")
    endpoint, (row,) = device.rows[part.id]
    assert row.write is not None
    sent = [
        row.write(endpoint, Command(key="", part="", capability="scene", value=Value.of(True), transition=one))
        for one in (0.0, 2.5)
    ]
    assert [dict(one[0].server_call(5, 1)[1])["payload"] for one in sent] == [
        {"groupID": 7, "sceneID": 3},
        {"groupID": 7, "sceneID": 3, "transitionTime": 2500},
    ]


def test_groups_and_numbers_of_scenes_are_read_as_far_as_they_make_sense() -> None:
    one = node({**LAMP, **GROUPS, "1/98/2": [{"0": 2, "254": 1}, {"0": -1}, {"sceneCount": 3}, "x"]})
    assert groups_at(one.endpoints[0], one.endpoints[1]) == (0, 7)
    assert scene_count(one.endpoints[1]) == 5
    assert scene_numbers({"status": 0, "sceneList": [1, "x", True, 4]}) == (1, 4)
    assert (scene_numbers(None), scene_numbers({"sceneList": None})) == ((), ())


async def test_a_stored_scene_is_read_and_recalled_and_one_more_too() -> None:
    async with house() as home:
        sightings, reports = home.sightings(), home.reports()
        lamp = await home.commission("lamp", DeviceState(text="on", is_on=True, brightness=0.5))
        await reading(reports, "on_off", lambda one: one is True)
        lamp.store_scene(2, "Film")
        seen = await receive(sightings, lambda one: any(part.service_type == "x_scene" for part in one.parts))
        (scene,) = [part for part in seen.parts if part.service_type == "x_scene"]
        assert (scene.id, scene.name) == ("1-scene-0-2", "Film")
        assert {one.capability for one in scene.values} == {"on_off", "level", "color_temperature"}
        assert (await home.command("node-1", scene.id, "scene", True)).success
        assert home.orders != []
        lamp.store_scene(3, "Dinner")
        await receive(sightings, lambda one: sum(part.service_type == "x_scene" for part in one.parts) == 2)
        lamp.is_available = False
        home.server.miss(lamp)
        await reading(reports, "reachable", lambda one: one is False)
        lamp.is_available = True
        home.server.reach(lamp)
        await reading(reports, "reachable", lambda one: one is True)
        asked = [args["command_name"] for name, args in home.server.calls if name == "device_command"]
        assert asked.count("ViewScene") == 3  # one, then both; none again
