"""Which announcements are one device, and what that device then is."""

from itertools import permutations

import pytest
from tests.discovery.announcements import announce, part_of, tell

from homebot.devices import DeviceChange, Sighting
from homebot.devices.device import EVERYTHING
from homebot.devices.part import Capability, Part
from homebot.discovery import DeviceIndex
from homebot.words.queries import parse_query

IEEE = "eui64:00158d0001abcdef"
MAC = "mac:aabbccddeeff"


def after(index: DeviceIndex, *sightings: Sighting) -> tuple[DeviceChange, ...]:
    """Return what the sightings change."""
    for one in sightings:
        index.observe(one)
    return index.pop_changes()


def kinds(changes: tuple[DeviceChange, ...]) -> list[tuple[str, str, str]]:
    return [(one.kind, one.device.id, one.other) for one in changes]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_device_has_no_other_names_than_those_that_it_is_given(index: DeviceIndex, order: tuple[int, int]) -> None:
    """Not those of its parts: in Home Assistant only one config of a device needs its name."""
    named = announce("sensor/t", part_of("temperature_sensor", "temperature", id="t"), ids=(MAC,), name="Bedroom")
    nameless = announce("sensor/h", part_of("humidity_sensor", "humidity", id="h", name="Wet"), ids=(MAC,), name="")
    both = (named, nameless)
    after(index, *(both[number] for number in order))
    (device,) = index.devices()
    assert (device.name, device.names) == ("Bedroom", ("Bedroom",))


@pytest.mark.parametrize(("part_name", "name", "device_id"), [("Wet", "Wet", "wet"), ("", "Node h", "node_h")])
def test_a_device_without_name_is_called_as_its_part_or_its_key(
    index: DeviceIndex, part_name: str, name: str, device_id: str
) -> None:
    after(index, announce("sensor/node_h", part_of("humidity_sensor", "humidity", name=part_name), ids=(MAC,), name=""))
    (device,) = index.devices()
    assert (device.name, device.names, device.id) == (name, (name,), device_id)


def test_the_entities_of_one_device_are_one_device_told_of_once(index: DeviceIndex) -> None:
    changes = after(
        index,
        announce("sensor/a", part_of("temperature_sensor", "temperature", id="t", category="diagnostic"), ids=(MAC,)),
        announce("light/a", part_of("light", "on_off", id="l", writes=("a/set",)), ids=(MAC,), area="Küche"),
        announce("update/a", part_of("x_update", "version", id="u", category="config"), ids=(MAC,)),
    )
    assert kinds(changes) == [("appeared", "desk_lamp", "")]
    device = changes[0].device
    assert (device.service_type, device.service_types, device.area) == ("light", ("light",), "Küche")
    assert [one.id for one in device.parts] == ["t", "l", "u"]
    assert device.endpoints[0].command_address == "words:homeassistant:light/a#l"
    assert device.evidence == ()


@pytest.mark.parametrize(
    ("types", "expected"),
    [
        (("switch", "temperature_sensor", "room_air_conditioner"), "room_air_conditioner"),
        (("temperature_sensor", "switch", "x_humidifier"), "x_humidifier"),
        (("occupancy_sensor", "light", "door_lock", "closure"), "closure"),
        (("occupancy_sensor", "switch", "camera"), "camera"),
        (("temperature_sensor", "smoke_co_alarm"), "smoke_co_alarm"),
        (("electrical_meter", "temperature_sensor", "plug"), "plug"),
    ],
)
def test_a_device_is_of_the_type_that_it_is_there_for(
    index: DeviceIndex, types: tuple[str, ...], expected: str
) -> None:
    parts = [part_of(one, "on_off", id=one, writes=(one,)) for one in types]
    (change,) = after(index, announce("device/a", *parts, ids=(MAC,)))
    assert change.device.service_type == expected
    assert change.device.endpoints[0].command_address == f"words:homeassistant:device/a#{expected}"


def test_a_device_that_is_described_anew_before_it_was_told_of_was_announced(index: DeviceIndex) -> None:
    index.observe(announce("l", part_of(), ids=(MAC,)).model_copy(update={"why": "its description changed"}))
    (change,) = index.pop_changes()
    assert (change.kind, change.why) == ("appeared", "it was announced")


def test_one_lamp_through_two_conventions_is_one_lamp_with_two_routes(index: DeviceIndex) -> None:
    """The device's own convention first, and the evidence in words."""
    lamp = part_of("light", "on_off", "level", id="x", reads=("z/lamp",), writes=("z/lamp/set",))
    own = part_of("light", "on_off", id="state", reads=("z/lamp",), writes=("z/lamp/set",))
    first = after(index, announce("light/0x17", lamp, ids=(IEEE, "id:zigbee2mqtt_0x17"), name="Lamp"))
    second = after(index, announce("z/0x17", own, convention="zigbee2mqtt", ids=(IEEE,), name="lamp"))

    assert kinds(first) == [("appeared", "lamp", "")]
    assert kinds(second) == [("merged", "lamp", "")]
    assert second[0].why == f"same {IEEE} in homeassistant:light/0x17 and zigbee2mqtt:z/0x17"
    device = second[0].device
    assert device.evidence == (second[0].why,)
    (only,) = device.parts
    assert [(route.convention, route.part) for route in only.routes] == [
        ("zigbee2mqtt", "state"),
        ("homeassistant", "x"),
    ]
    assert [one.key for one in device.endpoints] == ["zigbee2mqtt:z/0x17"]
    assert index.devices("lights") == (device,)


def test_two_devices_that_turn_out_to_be_one_are_told_of_and_the_older_lives_on(index: DeviceIndex) -> None:
    """And when the bond goes, the younger is a device again."""
    lamp = part_of(id="l")
    after(index, announce("light/a", lamp, ids=("id:serial-4711",), name="A"))
    after(index, announce("shelly1", lamp, convention="shelly", ids=(MAC,), name="B"))
    both = announce("sensor/a", part_of("x_sensor", id="s"), ids=("id:serial-4711", MAC), name="A")

    merged = after(index, both)
    assert kinds(merged) == [("removed", "b", "a"), ("merged", "a", "b")]
    assert index.get("b") is None
    assert "same id:serial-4711" in merged[1].why
    assert f"same {MAC}" in merged[1].why

    parted = after(index, both.model_copy(update={"kind": "removed"}))
    assert ("unmerged", "a", "b") in kinds(parted)
    assert ("appeared", "b", "") in kinds(parted)
    assert {one.id for one in index.devices()} == {"a", "b"}


def test_the_address_of_a_host_does_not_make_its_devices_one(index: DeviceIndex) -> None:
    """Homie devices name the computer that speaks for them."""
    for number in range(5):
        index.observe(announce(f"dev{number}", part_of(id="p"), convention="homie", ids=(MAC,), name=f"Dev {number}"))
    assert len(index.devices()) == 5


def test_a_host_itself_is_none_of_its_devices(index: DeviceIndex) -> None:
    after(
        index,
        announce("host", part_of(id="p"), convention="shelly", ids=(MAC,), name="Host"),
        announce("dev1", part_of(id="p"), convention="homie", ids=(MAC, "id:dev1"), name="One"),
        announce("dev2", part_of(id="p"), convention="homie", ids=(MAC, "id:dev2"), name="Two"),
    )
    assert {one.id for one in index.devices()} == {"host", "one", "two"}


@pytest.mark.parametrize("shared", ["id:mqtt-io", "id:ESP32", "id:1", "id:abc"])
def test_a_word_that_many_devices_have_is_no_identity(index: DeviceIndex, shared: str) -> None:
    after(
        index,
        announce("light/a", part_of(id="p"), ids=(shared, "mac:000000000001"), name="A"),
        announce("light/b", part_of(id="p"), ids=(shared, "mac:000000000002"), name="B"),
    )
    assert len(index) == 2


def test_an_identifier_of_devices_with_different_addresses_is_no_identity_in_any_order() -> None:
    claims = [
        announce("light/a", part_of(id="p"), ids=("mac:000000000001", "id:my-lamps"), name="A"),
        announce("light/b", part_of(id="p"), ids=("mac:000000000002", "id:my-lamps"), name="B"),
        announce("light/c", part_of(id="p"), ids=("id:my-lamps",), name="C"),
    ]
    for order in permutations(claims):
        index = DeviceIndex(forget_after=1000.0)
        after(index, *order)
        assert {one.id for one in index.devices()} == {"a", "b", "c"}


def test_equal_names_topics_and_part_ids_do_not_make_one_device(index: DeviceIndex) -> None:
    """ESPHome's default unique ids are the same on every node."""
    same = part_of(id="ESPlightlight")
    after(
        index,
        announce("light/a/light", same, ids=("mac:000000000001",), name="Light"),
        announce("light/b/light", same, ids=("mac:000000000002",), name="Light"),
    )
    assert [one.id for one in index.devices()] == ["light", "light_0002"]


def test_two_relays_of_one_device_stay_two(index: DeviceIndex) -> None:
    """Also where they speak on one topic, and when a second convention tells of both."""
    after(
        index,
        announce("switch/l1", part_of("switch", id="u1", name="L1", reads=("z",), writes=("z/l1",)), ids=(IEEE,)),
        announce("switch/l2", part_of("switch", id="u2", name="L2", reads=("z",), writes=("z/l2",)), ids=(IEEE,)),
        announce(
            "z",
            part_of("switch", id="state_l1", name="l1", reads=("z",), writes=("z/set",)),
            part_of("switch", id="state_l2", name="l2", reads=("z",), writes=("z/set",)),
            convention="zigbee2mqtt",
            ids=(IEEE,),
        ),
    )
    (device,) = index.devices()
    assert [[route.part for route in one.routes] for one in device.parts] == [["state_l1", "u1"], ["state_l2", "u2"]]


def test_sensors_of_two_conventions_find_each_other_by_their_ids_and_settings_are_no_loads(index: DeviceIndex) -> None:
    """Where no name helps; the longer common id is the surer one."""
    topic, foreign = ("z/t",), (IEEE, "id:z_0x1")
    after(
        index,
        announce(
            "z",
            part_of("temperature_sensor", "temperature", id="temperature", reads=topic),
            part_of("temperature_sensor", "temperature", id="local_temperature", reads=topic, category="diagnostic"),
            part_of("switch", "on_off", id="state", reads=topic, writes=("z/t/set",)),
            convention="zigbee2mqtt",
            ids=(IEEE,),
        ),
        announce(
            "a", part_of("temperature_sensor", "temperature", id="0x1_local_temperature_z", reads=topic), ids=foreign
        ),
        announce("b", part_of("temperature_sensor", "temperature", id="0x1_temperature_z", reads=topic), ids=foreign),
        announce(
            "c",
            part_of("switch", "on_off", id="0x1_state_lock", reads=topic, writes=("z/t/set/l",), category="config"),
            ids=foreign,
        ),
        announce("d", part_of("switch", "on_off", id="0x1_switch", reads=topic, writes=("z/t/set",)), ids=foreign),
    )
    (device,) = index.devices()
    assert [[route.part for route in one.routes] for one in device.parts] == [
        ["temperature", "0x1_temperature_z"],
        ["local_temperature", "0x1_local_temperature_z"],
        ["state", "0x1_switch"],
        ["0x1_state_lock"],
    ]


def test_a_setting_that_one_convention_calls_a_switch_is_not_the_load(index: DeviceIndex) -> None:
    """What Home Assistant is told of a Legrand 064882 or a Sber SBDV-00196, beside Zigbee2MQTT's own list."""
    state = ("z/plug",)
    own = (
        part_of("switch", "on_off", id="switch", writes=("z/plug/set",), reads=state),
        part_of("x_setting", "state", id="device_mode", writes=("z/plug/set",), reads=state),
    )
    mode = part_of("switch", "on_off", id="0x17_switch_device_mode_z", writes=("z/plug/set/device_mode",), reads=state)
    load = part_of("switch", "on_off", id="0x17_switch_z", writes=("z/plug/set",), reads=state)
    for one in (
        announce("z/0x17", *own, convention="zigbee2mqtt", ids=(IEEE,)),
        announce("switch/0x17/device_mode", mode, ids=(IEEE,)),
        announce("switch/0x17/switch", load, ids=(IEEE,)),
    ):
        index.observe(one)
    (device,) = index.devices()
    ways = {one.id: [way.part for way in one.routes] for one in device.parts}
    assert ways == {
        "switch": ["switch", "0x17_switch_z"],
        "device_mode": ["device_mode"],
        "0x17_switch_device_mode_z": ["0x17_switch_device_mode_z"],
    }


def test_the_same_entity_announced_twice_is_one_part(index: DeviceIndex) -> None:
    """Where both places name the device."""
    lamp = part_of("light", "on_off", id="l", writes=("a/set",))
    after(index, announce("light/old", lamp, ids=(MAC,)), announce("light/new", lamp, ids=(MAC,)))
    (device,) = index.devices()
    assert [len(one.routes) for one in device.parts] == [2]
    assert device.conflicts == ()


def test_a_second_source_of_a_known_part_with_other_topics_changes_nothing(index: DeviceIndex) -> None:
    after(index, announce("light/a", part_of("light", "on_off", id="l", writes=("a/set",)), ids=(MAC,)))
    evil = announce("light/evil", part_of("light", "on_off", id="l", writes=("evil",)), ids=(MAC,))
    assert kinds(after(index, evil)) == [("changed", "desk_lamp", ""), ("conflict", "desk_lamp", "")]
    assert after(index, evil) == ()
    (device,) = index.devices()
    assert [one.part.writes for one in device.parts] == [("a/set",)]
    assert device.conflicts == ("homeassistant:light/evil announces 'l', which is homeassistant:light/a's",)
    resolved = after(index, evil.model_copy(update={"kind": "removed"}))
    assert kinds(resolved) == [("changed", "desk_lamp", ""), ("resolved", "desk_lamp", "")]


def test_a_lamp_that_names_another_devices_command_topic_is_told_nothing_there_until_that_is_gone(
    index: DeviceIndex,
) -> None:
    lock = announce("lock/a", part_of("door_lock", "lock", id="k", writes=("a/set",)), ids=(MAC,), name="Door")
    lamp = announce("light/b", part_of(id="l", writes=("a/set",)), ids=("mac:000000000001",), name="Evil")
    after(index, lock)
    changes = after(index, lamp)

    assert ("conflict", "door", "evil") in kinds(changes)
    evil = index.get("evil")
    assert evil is not None
    assert evil.parts[0].routes == ()
    assert evil.endpoints[0].command_address == ""
    assert evil.conflicts == ("homeassistant:light/b takes commands on a/set, which belongs to door",)
    door = index.get("door")
    assert door is not None
    assert len(door.parts[0].routes) == 1

    resolved = after(index, lock.model_copy(update={"kind": "removed"}))
    assert ("resolved", "evil", "") in kinds(resolved)
    evil = index.get("evil")
    assert evil is not None
    assert len(evil.parts[0].routes) == 1


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_an_announcement_in_the_name_of_another_device_is_told_nothing_there(
    index: DeviceIndex, order: tuple[int, int]
) -> None:
    """A lock that says who it is may be said to have a lamp as well, whose word for off opens the door."""
    ids = ("id:lock-17",)
    topic = "front_door/set"
    lock = announce(
        "k", part_of("door_lock", "lock", id="k", writes=(topic,)), ids=ids, on="homeassistant/front_door/config"
    )
    lamp = announce("l", part_of("light", "on_off", id="l", writes=(topic,)), ids=ids, on="homeassistant/evil/config")
    after(index, *((lock, lamp)[number] for number in order))

    (device,) = index.devices()
    assert {one.part.service_type: len(one.routes) for one in device.parts} == {"door_lock": 1, "light": 0}
    (told,) = device.conflicts
    assert "where another announcement of the device takes different ones" in told


def test_a_lock_that_is_announced_again_where_that_does_not_name_it_has_the_values_of_the_first_alone(
    index: DeviceIndex,
) -> None:
    bolt = part_of("door_lock", "lock", id="k", writes=("front_door/set",))
    own = announce("own", bolt, ids=("id:lock-17",), on="homeassistant/front_door/config")
    evil = announce("evil", bolt, ids=("id:lock-17",), on="homeassistant/evil/config")
    after(index, own, evil)
    index.report(tell(own, "lock", "unlocked", part="k", at=10))
    index.report(tell(evil, "lock", "locked", part="k", at=20))
    (device,) = index.devices()
    assert [(len(one.routes), one.part.service_type) for one in device.parts] == [(1, "door_lock")]
    assert [one.value.plain() for one in device.states] == ["unlocked"]


def test_of_two_that_want_one_topic_with_equal_right_neither_is_told_anything_there(index: DeviceIndex) -> None:
    """And both say so; who came first says nothing, for it may be either."""
    lock = announce("lock/x1", part_of("door_lock", "lock", id="k", writes=("t/set",)), ids=("id:one",), name="Door")
    lamp = announce("light/x2", part_of(id="l", writes=("t/set",)), ids=("id:two",), name="Evil")
    after(index, lamp, lock)
    door, evil = index.devices()
    assert not door.parts[0].routes
    assert not evil.parts[0].routes
    assert door.conflicts == ("homeassistant:lock/x1 takes commands on t/set, which belongs to evil",)
    assert evil.conflicts == ("homeassistant:light/x2 takes commands on t/set, which belongs to door",)


def test_devices_behind_one_bridge_may_share_its_topic(index: DeviceIndex) -> None:
    """An infrared blaster has one topic for all that it controls."""
    for number in range(3):
        one = part_of(id="l", writes=("blaster/send",))
        after(index, announce(f"light/{number}", one, ids=(f"id:blaster-{number}",), facts={"via_device": "blaster"}))
    assert all(one.parts[0].routes and not one.conflicts for one in index.devices())


def test_facts_say_who_said_them_and_when(index: DeviceIndex) -> None:
    lamp = announce("light/a", part_of(id="l"), ids=(IEEE,), facts={"model": "E27", "sw_version": "1"}, at=5)
    own = announce(
        "z/a", part_of(id="s"), convention="zigbee2mqtt", ids=(IEEE,), name="lamp", facts={"model": "LED1"}, at=7
    )
    newer = announce("light/a", part_of(id="l"), ids=(IEEE,), facts={"model": "E27", "sw_version": "2"}, at=9)
    after(index, lamp, own, newer)
    (device,) = index.devices()
    assert [(one.name, one.value, one.convention, one.said_at.sec) for one in device.facts] == [
        ("name", "lamp", "zigbee2mqtt", 7),
        ("model", "LED1", "zigbee2mqtt", 7),
        ("name", "Desk lamp", "homeassistant", 5),
        ("model", "E27", "homeassistant", 5),
        ("sw_version", "2", "homeassistant", 9),
    ]
    assert device.names == ("lamp", "Desk lamp")
    assert {one.key: one.value for one in device.metadata} == {"model": "LED1", "sw_version": "2"}


@pytest.mark.parametrize(
    ("names", "conventions", "value"),
    [
        (("Gen 1", "Gen 2", "Gen 3"), ("homeassistant",) * 3, "names Gen 1, Gen 2, Gen 3"),
        (("Gen 1", "gen 1"), ("homeassistant",) * 2, None),
        (("Gen 1", ""), ("homeassistant",) * 2, None),
        (("Gen 1", "0x17"), ("homeassistant", "zigbee2mqtt"), None),
    ],
)
def test_several_names_in_one_convention_are_a_fact(
    index: DeviceIndex, names: tuple[str, ...], conventions: tuple[str, ...], value: str | None
) -> None:
    """Three relays of a home-made bridge have one identifier, and perhaps are several devices."""
    for number, (name, convention) in enumerate(zip(names, conventions, strict=True)):
        index.observe(announce(f"k{number}", part_of(id=f"p{number}"), ids=(IEEE,), name=name, convention=convention))
    (device,) = index.devices()
    assert next((one.value for one in device.facts if one.name == "several_names"), None) == value


def test_a_renamed_device_keeps_its_id(index: DeviceIndex) -> None:
    after(index, announce("light/a", part_of(id="l"), ids=(IEEE,), name="Büro-Lampe"))
    changes = after(index, announce("light/a", part_of(id="l"), ids=(IEEE,), name="Hall"))
    assert [(one.kind, one.device.id, one.device.name) for one in changes] == [("changed", "buro_lampe", "Hall")]


def test_states_come_from_the_newest_word_of_any_route(index: DeviceIndex) -> None:
    """Live words count more than kept ones."""
    lamp = announce("light/a", part_of("light", "on_off", id="l"), ids=(IEEE,))
    own = announce("z/a", part_of("light", "on_off", id="s"), convention="zigbee2mqtt", ids=(IEEE,))
    after(index, lamp, own)
    index.report(tell(lamp, "on_off", True, part="l", at=10))
    index.report(tell(own, "on_off", False, part="s", at=20, retained=True))
    (device,) = index.devices()
    (state,) = device.states
    assert (state.value.plain(), state.live, state.since.sec, state.part) == (True, True, 10, "s")
    index.report(tell(own, "on_off", False, part="s", at=30))
    (state,) = index.devices()[0].states
    assert (state.value.plain(), state.live, state.since.sec) == (False, True, 20)


def test_a_device_of_many_entities_is_bounded(index: DeviceIndex) -> None:
    for number in range(1100):
        index.observe(announce(f"sensor/{number}", part_of("x_sensor", id=str(number)), ids=(MAC,)))
    (device,) = index.devices()
    assert len(device.parts) == 1000
    assert index.counters.rejected == 100


def test_parts_beyond_a_thousand_are_left_out_and_that_is_told(index: DeviceIndex) -> None:
    for source in ("a", "b"):
        sensors = [part_of("x_sensor", id=f"{source}{number}") for number in range(501)]
        index.observe(announce(source, *sensors, ids=(MAC,)))

    (device,) = index.devices()
    assert len(device.parts) == 1000
    assert device.conflicts == ("2 further parts are ignored; a device may have at most 1,000",)


def test_many_parts_that_two_conventions_tell_of_find_each_other(index: DeviceIndex) -> None:
    for convention, ids in (("zigbee2mqtt", (IEEE,)), ("homeassistant", (IEEE, "id:lamp"))):
        sensors = [part_of("x_sensor", "measurement", id=f"s{n}", name=f"Sensor {n}") for n in range(800)]
        index.observe(announce("many", *sensors, convention=convention, ids=ids))

    (device,) = index.devices()
    assert [(one.id, len(one.routes)) for one in device.parts] == [(f"s{n}", 2) for n in range(800)]


def test_a_device_that_tells_more_of_who_it_is_is_described_anew(index: DeviceIndex) -> None:
    """As a Shelly does whose announcement comes after its first word."""
    button, lamp = part_of("generic_switch", "press", id="input"), part_of("light", "on_off", id="light")
    after(index, announce("lamp", button, ids=("id:shellyrgbw2-0BBFDB",)))
    after(index, announce("lamp", button, lamp, ids=(MAC, "id:shellyrgbw2-0BBFDB")))
    (device,) = index.devices()
    assert MAC in device.identifiers
    assert {one.part.service_type for one in device.parts} == {"generic_switch", "light"}


def test_a_part_can_do_what_any_of_its_ways_can(index: DeviceIndex) -> None:
    """Each way says what it takes, where that is not all; a way of words alone takes nothing."""
    rich = part_of("light", "on_off", "level", id="x", reads=("z/lamp",), writes=("z/lamp/set",))
    poor = part_of("light", "on_off", "power", id="state", reads=("z/lamp",))
    after(
        index,
        announce("light/0x17", rich, ids=(IEEE,)),
        announce("z/0x17", poor, convention="zigbee2mqtt", ids=(IEEE,)),
    )
    (device,) = index.devices()
    (only,) = device.parts
    assert [(one.name, one.settable) for one in only.part.capabilities] == [
        ("on_off", True),
        ("power", False),
        ("level", True),
    ]
    assert [(way.part, way.takes) for way in only.routes] == [("state", ()), ("x", EVERYTHING)]
    assert [way.can("level") for way in only.routes] == [False, True]
    assert device.endpoints[0].address == "words:zigbee2mqtt:z/0x17#state"
    assert device.endpoints[0].command_address == "words:homeassistant:light/0x17#x"
    (id_of_one,) = index.find(parse_query("can=level"))
    assert id_of_one == device.id


def test_the_words_of_all_ways_are_those_of_the_part(index: DeviceIndex) -> None:
    """The span is that of the best way that can be told."""

    def lamp(part_id: str, *, settable: bool, options: tuple[str, ...], top: float) -> Part:
        effect = Capability(name="effect", settable=settable, options=options)
        level = Capability(name="level", settable=settable, bounds=(0.0, top))
        return Part(id=part_id, service_type="light", capabilities=(effect, level), reads=("z",), writes=("z/set",))

    after(
        index,
        announce("light/a", lamp("x", settable=True, options=("blink", "fire"), top=90.0), ids=(IEEE,)),
        announce(
            "z",
            lamp("state", settable=True, options=("blink", "okay"), top=100.0),
            convention="zigbee2mqtt",
            ids=(IEEE,),
        ),
    )
    effect, level = index.devices()[0].parts[0].part.capabilities
    assert effect.options == ("blink", "okay", "fire")
    assert level.bounds == (0.0, 100.0)

    mute = lamp("state", settable=False, options=("said",), top=80.0)
    after(index, announce("z", mute, convention="zigbee2mqtt", ids=(IEEE,)))
    effect, level = index.devices()[0].parts[0].part.capabilities
    assert (effect.settable, effect.options, level.bounds) == (True, ("blink", "fire"), (0.0, 90.0))


@pytest.mark.parametrize("number", ["123456", "1234567", "12345678", "0123456789", "1234567890", "123456789012"])
def test_a_lock_bridge_whose_identifier_is_a_number_is_one_device_that_takes_every_command(
    index: DeviceIndex, number: str
) -> None:
    topic = f"nuki/{number}/lock/action"
    lock = part_of("door_lock", "lock", id="lock", writes=(topic,))
    buttons = [part_of("generic_switch", "push", id=f"button{count}", writes=(topic,)) for count in range(33)]
    for one in (lock, *buttons):
        place = f"homeassistant/{one.service_type}/{number}/{one.id}/config"
        index.observe(announce(f"{number}/{one.id}", one, ids=(f"id:{number}",), on=place))
    (device,) = index.devices()
    assert len(device.parts) == 34
    assert all(one.routes for one in device.parts)
    assert device.conflicts == ()
