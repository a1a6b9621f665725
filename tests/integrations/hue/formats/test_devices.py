"""Resources of a Hue bridge become devices, values and requests."""

from collections.abc import Collection

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.gateways.checked_command import checked_command

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.hue.formats.devices import HueService, bridge_identifiers, devices_of
from homebot.integrations.hue.formats.resources import Fields, HueBody, HueResources, HueRow
from homebot.integrations.hue.formats.service_rows import press_of

LIGHT: Fields = {
    "on": {"on": True},
    "dimming": {"brightness": 40.0, "min_dim_level": 5.0},
    "color_temperature": {
        "mirek": 370,
        "mirek_valid": True,
        "mirek_schema": {"mirek_minimum": 153, "mirek_maximum": 454},
    },
    "color": {"xy": {"x": 0.4573, "y": 0.41}},
    "gradient": {"points": [], "points_capable": 5},
    "effects": {"status": "no_effect", "effect_values": ["no_effect", "candle"]},
}


def service(kind: str, resource: Fields, **device: object) -> HueService:
    """The only service of a device."""
    resources = HueResources()
    listed = [{"id": "service", "type": kind, **resource}]
    services = [{"rid": "service", "rtype": kind}]
    resources.replace([*listed, {"id": "device", "type": "device", "services": services, **device}])
    (found,) = devices_of(resources, resources.ids)
    return found.services[0]


def row(kind: str, resource: Fields, capability: str) -> HueRow:
    return next(one for one in service(kind, resource).rows if one.capability == capability)


def read(kind: str, resource: Fields, capability: str) -> PlainValue:
    found = row(kind, resource, capability)
    assert found.read is not None
    return found.read(resource)


def write(resource: Fields, capability: str, value: PlainValue, seconds: float = 0.0) -> HueBody:
    found = row("light", resource, capability)
    assert found.write is not None
    return found.write(
        resource, checked_command(service("light", resource).part, capability, value, transition=seconds)
    )


@pytest.mark.parametrize(
    ("capability", "value", "body"),
    [
        ("on_off", False, {"on": {"on": False}}),
        ("level", 1.0, {"on": {"on": True}, "dimming": {"brightness": 1.0}}),
        ("level", 0.0, {"on": {"on": False}}),
        ("color_temperature", 2203.0, {"on": {"on": True}, "color_temperature": {"mirek": 454}}),
        ("color", (0.0, 100.0), {"on": {"on": True}, "color": {"xy": {"x": 0.701, "y": 0.299}}}),
        ("effect", "candle", {"on": {"on": True}, "effects": {"effect": "candle"}}),
        ("locate", True, {"identify": {"action": "identify"}}),
    ],
)
def test_a_light_is_commanded_in_one_request(capability: str, value: PlainValue, body: HueBody) -> None:
    assert write(LIGHT, capability, value) == body


def test_a_transition_is_in_milliseconds_and_at_most_6000_seconds() -> None:
    assert service("light", LIGHT).part.fades
    assert write(LIGHT, "on_off", True, 2.5)["dynamics"] == {"duration": 2500}
    with pytest.raises(RefusedError, match="it takes 0 to 6000 s"):
        write(LIGHT, "on_off", True, 6001.0)


@pytest.mark.parametrize(("capability", "value"), [("level", 101.0), ("color_temperature", 9000.0), ("effect", "rave")])
def test_a_value_that_the_light_cannot_have_is_refused(capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        write(LIGHT, capability, value)


def test_a_light_has_a_white_or_a_colour() -> None:
    assert (read("light", LIGHT, "color_temperature"), read("light", LIGHT, "color")) == (2703.0, None)
    colored = {**LIGHT, "color_temperature": {"mirek": None, "mirek_valid": False}}
    assert read("light", colored, "color_temperature") is None
    assert read("light", colored, "color") == pytest.approx((38.7, 52.9), abs=0.1)


def test_a_gradient_light_has_the_colour_of_its_first_point_and_takes_one_for_all() -> None:
    """As a bridge lists it, ``color`` is that point; a colour that is set ends the gradient."""
    first, second = {"x": 0.5022, "y": 0.4466}, {"x": 0.5614, "y": 0.4058}
    white = {"mirek": None, "mirek_valid": False}
    points = [{"color": {"xy": one}} for one in (first, second)]
    light = {**LIGHT, "color": {"xy": first}, "color_temperature": white, "gradient": {"points": points}}
    assert read("light", light, "color") == pytest.approx((43.9, 78.8), abs=0.1)
    assert write(light, "color", (0.0, 100.0)) == {"on": {"on": True}, "color": {"xy": {"x": 0.701, "y": 0.299}}}


def test_a_light_without_limits_has_those_of_the_maker() -> None:
    described = service("light", {**LIGHT, "color_temperature": {"mirek_schema": {"mirek_maximum": 65535}}}).part
    bounds = next(one.bounds for one in described.capabilities if one.name == "color_temperature")
    assert bounds == pytest.approx((2000, 6536), abs=25)


def test_a_socket_is_no_lamp() -> None:
    assert service("light", {"on": {"on": True}}, metadata={"archetype": "plug"}).part.service_type == "plug"
    assert service("light", {"on": {"on": True}}).part.service_type == "light"


@pytest.mark.parametrize(
    ("kind", "resource", "capability", "value"),
    [
        ("motion", {"enabled": True, "motion": {"motion_report": {"motion": True}}}, "occupancy", True),
        ("motion", {"enabled": False, "motion": {"motion_report": {"motion": True}}}, "occupancy", None),
        ("motion", {"motion": {"motion": True, "motion_valid": False}}, "occupancy", None),
        ("camera_motion", {"enabled": True, "motion": {"motion_report": {"motion": True}}}, "occupancy", True),
        ("temperature", {"temperature": {"temperature": 18.139999389648438}}, "temperature", 18.14),
        ("temperature", {"temperature": {"temperature": None}}, "temperature", None),
        ("light_level", {"light": {"light_level_report": {"light_level": 1}}}, "illuminance", 1.0),
        ("light_level", {"light": {"light_level_report": {"light_level": 30001}}}, "illuminance", 1000.0),
        ("light_level", {"light": {"light_level": 0}}, "illuminance", 0.0),
        ("contact", {"contact_report": {"state": "no_contact"}}, "contact", True),
        ("contact", {"contact_report": {"state": "jammed"}}, "contact", None),
        ("tamper", {"tamper_reports": [{"state": "not_tampered"}, {"state": "tampered"}]}, "tamper", True),
        ("tamper", {"tamper_reports": []}, "tamper", None),
        ("device_power", {"power_state": {"battery_level": 7, "battery_state": "critical"}}, "battery_low", True),
        ("device_power", {"power_state": {"battery_level": 7, "battery_state": None}}, "battery", 7.0),
    ],
)
def test_a_sensor_is_read(kind: str, resource: Fields, capability: str, value: PlainValue) -> None:
    assert read(kind, resource, capability) == value


def test_a_doorbell_is_a_button() -> None:
    bell = service("bell_button", {"button": {"event_values": ["initial_press"]}}).part
    assert (bell.service_type, bell.capabilities[0].options) == ("generic_switch", ("initial_press",))


def test_lights_that_notice_motion_in_a_room_are_a_sensor_there() -> None:
    area = {"id": "area", "type": "motion_area_configuration", "name": "Sofa", "services": [{"rid": "motion"}]}
    motion = {"id": "motion", "type": "security_area_motion", "enabled": True, "motion": {"motion": True}}
    resources = HueResources()
    resources.replace([{**area, "group": {"rid": "Hall", "rtype": "room"}}, motion, group("room", "Hall")])
    (found,) = devices_of(resources, resources.ids)
    assert (found.name, found.area, found.services[0].part.service_type) == ("Sofa", "Hall", "occupancy_sensor")
    assert described(resources, "update", {"id": "Hall", "metadata": {"name": "Hallway"}}) == {"area"}
    assert described(resources, "update", {"id": "area", "name": "Couch"}) == {"area"}


@pytest.mark.parametrize(
    ("kind", "recall"), [("scene", {"action": "active", "duration": 2000}), ("smart_scene", {"action": "activate"})]
)
def test_a_scene_takes_a_transition_and_one_that_follows_the_day_has_its_own(kind: str, recall: HueBody) -> None:
    resources = HueResources()
    scene = {"id": "scene", "type": kind, "group": {"rid": "room", "rtype": "room"}, "metadata": {"name": "Relax"}}
    resources.replace([{"id": "room", "type": "room", "metadata": {"name": "Hall"}}, scene])
    (found,) = devices_of(resources, {"room"})
    (only,) = found.services
    (write,) = (one.write for one in only.rows)
    assert write is not None
    assert only.part.fades is (kind == "scene")
    assert write(scene, checked_command(only.part, "scene", True, transition=2.0)) == {"recall": recall}


def test_a_turn_of_a_dial_is_a_press() -> None:
    report = {"action": "repeat", "rotation": {"direction": "counter_clock_wise", "steps": 30}, "updated": "now"}
    assert press_of({"relative_rotary": {"rotary_report": report}}) == ("rotate_left", "now")
    assert press_of({"button": {"last_event": "short_release"}}) == ("", "")


def test_the_bridge_has_the_addresses_by_which_others_know_it() -> None:
    assert bridge_identifiers("001788fffe123456") == ("eui64:001788fffe123456", "mac:001788123456")


def test_a_change_is_joined_with_the_rest() -> None:
    resources = HueResources()
    resources.replace([{"id": "a", "type": "light", "on": {"on": True}, "dimming": {"brightness": 3.0}}])
    assert not resources.change("update", {"id": "a", "dimming": {"brightness": 5.0}})
    assert resources.change("update", {"id": "a", "metadata": {"name": "Hall"}})
    assert resources.get("a")["dimming"] == {"brightness": 5.0}
    assert resources.get("a")["on"] == {"on": True}
    with pytest.raises(WireError, match="the resource b is unknown"):
        resources.change("update", {"id": "b"})


def test_a_change_in_a_house_of_many_lamps_describes_its_own_device_alone() -> None:
    resources = HueResources()
    lamps = range(30)
    resources.replace(
        [
            *({"id": f"light-{one}", "type": "light", "on": {"on": True}} for one in lamps),
            *({"id": f"radio-{one}", "type": "zigbee_connectivity"} for one in lamps),
            *(device(f"lamp-{one}", f"light-{one}", f"radio-{one}") for one in lamps),
            group("room", "Hall", *(f"lamp-{one}" for one in lamps)),
            group("zone", "Downstairs", "light-1", "light-2"),
            {"id": "scene", "type": "scene", "group": {"rid": "Hall"}, "metadata": {"name": "Relax"}},
        ]
    )
    assert described(resources, "update", {"id": "radio-7", "status": "disconnected"}) == {"lamp-7"}
    assert described(resources, "update", {"id": "lamp-7", "metadata": {"name": "Desk"}}) == {"lamp-7", "Hall"}
    assert described(resources, "update", group("zone", "Downstairs", "light-2", "light-3")) == {"lamp-1", "lamp-3"}
    assert described(resources, "update", group("room", "Hall", *(f"lamp-{one}" for one in range(29)))) == {
        "lamp-29",
        "Hall",
    }
    assert described(resources, "update", {"id": "scene", "metadata": {"name": "Read"}}) == {"Hall"}
    everything = {f"lamp-{one}" for one in range(29)} | {"Hall"}
    assert described(resources, "update", {"id": "Hall", "metadata": {"name": "Hallway"}}) == everything
    assert described(resources, "update", {"id": "light-7", "on": {"on": False}}) == set()


@pytest.mark.parametrize(("kind", "inside"), [("room", "lamp-1"), ("zone", "light-1")])
def test_a_scene_sets_the_lamps_of_its_room_or_zone(kind: str, inside: str) -> None:
    resources = HueResources()
    scene = {"id": "scene", "type": "scene", "group": {"rid": "Hall"}, "metadata": {"name": "Relax"}}
    lamps = [
        one
        for number in (1, 2)
        for one in ({"id": f"light-{number}", "type": "light"}, device(f"lamp-{number}", f"light-{number}"))
    ]
    resources.replace([*lamps, group(kind, "Hall", inside), scene])
    (scenes,) = devices_of(resources, ["Hall"])
    assert "id:hue:lamp-1" in scenes.services[0].part.members
    assert "id:hue:lamp-2" not in scenes.services[0].part.members


def device(rid: str, *services: str) -> Fields:
    listed = [{"rid": one} for one in services]
    return {"id": rid, "type": "device", "metadata": {"name": rid}, "services": listed}


def group(kind: str, rid: str, *inside: str) -> Fields:
    return {"id": rid, "type": kind, "metadata": {"name": rid}, "children": [{"rid": one} for one in inside]}


def described(resources: HueResources, kind: str, item: Fields) -> set[str]:
    return {one.id for one in devices_of(resources, resources.change(kind, item))}


NAMED = st.builds(
    lambda rid, name, references: {
        "id": rid,
        "type": {"a": "motion_area_configuration", "d": "device", "r": "room", "z": "zone", "s": "scene", "l": "light"}[
            rid[0]
        ],
        "metadata": {"name": name},
        "group": {"rid": next((one["rid"] for one in references), "")},
        "services": references if rid[0] in "ad" else [],
        "children": references if rid[0] in "rz" else [],
    },
    st.sampled_from(["a1", "d1", "d2", "r1", "z1", "s1", "s2", "l1", "l2"]),
    st.sampled_from(["Hall", "Kitchen"]),
    st.lists(st.fixed_dictionaries({"rid": st.sampled_from(["d1", "d2", "r1", "z1", "l1", "l2"])}), max_size=3),
)


@given(st.lists(NAMED, max_size=9), st.lists(st.tuples(st.sampled_from(["add", "update", "delete"]), NAMED)))
def test_what_changes_describe_is_what_a_new_list_would(
    listed: list[Fields], changes: list[tuple[str, Fields]]
) -> None:
    resources = HueResources()
    resources.replace(listed)
    known = facts_of(resources, resources.ids)
    for kind, item in changes:
        if kind == "update" and item["id"] not in resources.ids:
            continue
        ids = resources.change(kind, item)
        known = {rid: facts for rid, facts in known.items() if rid not in ids} | facts_of(resources, ids)
    again = HueResources()
    again.replace([resources.get(rid) for rid in resources.ids])
    assert known == facts_of(again, again.ids)


def facts_of(resources: HueResources, ids: Collection[str]) -> dict[str, tuple[object, ...]]:
    """By device: its name, room, zones and parts."""
    return {
        one.id: (one.name, one.area, one.metadata, {(service.id, service.part.name) for service in one.services})
        for one in devices_of(resources, ids)
    }


def room_with_a_scene(*actions: dict[str, object]) -> HueResources:
    lamps = [
        {"id": f"lamp-{number}", "type": "device", "services": [{"rid": f"light-{number}"}]} for number in range(1, 3)
    ]
    lights = [{"id": f"light-{number}", "type": "light", "on": {"on": True}} for number in range(1, 3)]
    targets = [
        {"target": {"rid": f"light-{number}", "rtype": "light"}, "action": action}
        for number, action in enumerate(actions, 1)
    ]
    scene = {"id": "scene", "type": "scene", "group": {"rid": "Hall"}, "metadata": {"name": "Relax"}}
    children = [{"rid": "lamp-1"}, {"rid": "lamp-2"}]
    room = {"id": "Hall", "type": "room", "metadata": {"name": "Hall"}, "children": children}
    resources = HueResources()
    resources.replace([*lamps, *lights, room, {**scene, "actions": targets}])
    return resources


def values_of(resources: HueResources) -> list[tuple[str, str, PlainValue]]:
    (scenes,) = devices_of(resources, ["Hall"])
    return [(one.member, one.capability, one.value.plain()) for one in scenes.services[0].part.values]


def test_a_scene_tells_the_values_of_its_lamps_and_of_one_that_is_off_nothing_else() -> None:
    relaxed: dict[str, object] = {"on": {"on": True}, "dimming": {"brightness": 56.7}}
    off: dict[str, object] = {"on": {"on": False}, "dimming": {"brightness": 10.0}}
    assert values_of(room_with_a_scene(relaxed, off)) == [
        ("id:hue:lamp-1#light", "on_off", True),
        ("id:hue:lamp-1#light", "level", 56.7),
        ("id:hue:lamp-2#light", "on_off", False),
    ]


def test_a_scene_with_more_than_homebot_can_say_tells_no_values() -> None:
    """Commands to its lamps would not do the same."""
    effect: dict[str, object] = {"on": {"on": True}, "effects": {"effect": "candle"}}
    assert values_of(room_with_a_scene(effect, {"on": {"on": True}})) == []


def test_a_scene_that_was_changed_in_the_app_has_its_new_values() -> None:
    resources = room_with_a_scene({"on": {"on": True}})
    actions = [{"target": {"rid": "light-1"}, "action": {"on": {"on": False}}}]
    assert "Hall" in resources.change("update", {"id": "scene", "actions": actions})
    assert values_of(resources) == [("id:hue:lamp-1#light", "on_off", False)]


@pytest.mark.parametrize(
    ("kind", "children", "members"),
    [
        ("room", ["lamp-1", "lamp-2", "sensor"], ("id:hue:lamp-1#light", "id:hue:lamp-2#light")),
        ("zone", ["light-1"], ("id:hue:lamp-1#light",)),
    ],
)
def test_the_lights_of_a_room_or_zone_are_a_group_of_its_lamps(
    kind: str, children: list[str], members: tuple[str, ...]
) -> None:
    resources = room_with_a_scene()
    services = [{"rid": "group", "rtype": "grouped_light"}]
    held = [{"rid": one} for one in children]
    room = {"id": "Hall", "type": kind, "metadata": {"name": "Hall"}, "children": held, "services": services}
    light = {"id": "group", "type": "grouped_light", "on": {"on": True}, "dimming": {"brightness": 40.0}, "color": {}}
    resources.change("add", {"id": "sensor", "type": "device", "services": []})
    resources.change("update", room)
    assert [one.id for one in devices_of(resources, ["Hall"])] == ["Hall"]  # the scenes alone
    assert "Hall" in resources.change("add", light)
    (lights,) = devices_of(resources, ["group"])
    assert [one.id for one in devices_of(resources, ["Hall"])] == ["group", "Hall"]
    (part,) = lights.services
    assert (lights.name, part.part.members) == ("Hall lights", members)
    assert part.part.is_group
    assert {one.name: (one.settable, one.readable) for one in part.part.capabilities} == {
        "on_off": (True, True),
        "level": (True, True),
        "color": (True, False),
    }


def test_all_lights_of_a_bridge_are_a_group_of_those_in_rooms_and_of_others() -> None:
    resources = room_with_a_scene()
    home = {"id": "home", "type": "bridge_home", "children": [{"rid": "Hall"}, {"rid": "lamp-3"}, {"rid": "zone"}]}
    for one in (
        {"id": "light-3", "type": "light", "on": {"on": True}},
        device("lamp-3", "light-3"),
        group("zone", "zone", "light-1"),
        {"id": "group", "type": "grouped_light", "on": {"on": True}},
        {**home, "services": [{"rid": "group", "rtype": "grouped_light"}]},
    ):
        resources.change("add", one)
    (lights,) = devices_of(resources, ["home"])
    assert (lights.name, lights.area) == ("Hue lights", "")
    assert set(lights.services[0].part.members) == {f"id:hue:lamp-{one}#light" for one in (1, 2, 3)}
    assert "group" in described(resources, "update", device("lamp-1"))
    (lights,) = devices_of(resources, ["home"])
    assert set(lights.services[0].part.members) == {f"id:hue:lamp-{one}#light" for one in (2, 3)}


def test_a_room_without_lamps_has_no_lights() -> None:
    resources = HueResources()
    services = [{"rid": "group"}]
    resources.replace(
        [
            {"id": "Hall", "type": "room", "metadata": {"name": "Hall"}, "services": services},
            {"id": "group", "type": "grouped_light", "on": {"on": True}},
        ]
    )
    assert list(devices_of(resources, ["Hall", "group"])) == []
