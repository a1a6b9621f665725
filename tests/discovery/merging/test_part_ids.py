"""The ids of parts last, whoever tells of them later."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.discovery.announcements import announce, part_of, tell

from homebot.devices import Sighting
from homebot.devices.part import Part
from homebot.discovery import DeviceIndex
from homebot.discovery.merging.part_ids import MAX_LOST, NO_IDS, Named, PartPlace, lost_ids, part_ids
from homebot.discovery.record import entry_record, read_entry

IEEE = "eui64:00158d0001abcdef"


FOREIGN = announce(
    "light/0x17", part_of("light", "on_off", id="0x17_light", reads=("z",), writes=("z/set",)), ids=(IEEE,)
)


NATIVE = announce(
    "0x17",
    part_of("light", "on_off", id="state", reads=("z",), writes=("z/set",)),
    convention="zigbee2mqtt",
    ids=(IEEE,),
)


SENSOR = announce("sensor/0x17", part_of("x_sensor", "value", id="0x17_sensor"), ids=(IEEE,))
"""What keeps the device alive while nobody tells of its lamp."""


def gone(sighting: Sighting) -> Sighting:
    return sighting.model_copy(update={"kind": "removed"})


def lamps(index: DeviceIndex) -> list[str]:
    return [one.id for device in index.devices() for one in device.parts if one.part.service_type == "light"]


def test_a_part_keeps_its_id_when_the_devices_own_convention_tells_of_it_later(index: DeviceIndex) -> None:
    index.observe(FOREIGN)
    assert lamps(index) == ["0x17_light"]
    index.observe(NATIVE)
    (device,) = index.devices()
    assert [(one.id, [way.part for way in one.routes]) for one in device.parts] == [
        ("0x17_light", ["state", "0x17_light"])
    ]


def test_a_part_keeps_its_id_when_the_announcement_that_gave_it_goes_and_comes_back(index: DeviceIndex) -> None:
    """Also when for a while nobody tells of the part."""
    seen = []
    for step in (SENSOR, FOREIGN, NATIVE, gone(FOREIGN), gone(NATIVE), NATIVE, FOREIGN, gone(NATIVE)):
        index.observe(step)
        seen += lamps(index)
    assert set(seen) == {"0x17_light"}
    assert len(seen) == 6


def test_ids_are_the_same_after_a_restart(index: DeviceIndex) -> None:
    """Whatever comes first then."""
    for one in (FOREIGN, NATIVE, SENSOR, gone(FOREIGN)):
        index.observe(one)
        index.devices()
    again = after_restart(index)
    assert lamps(again) == ["0x17_light"]
    for one in (NATIVE, FOREIGN):
        again.observe(one)
        assert lamps(again) == ["0x17_light"]


def test_a_device_of_a_file_from_before_there_were_ids_has_those_of_its_announcements() -> None:
    index = DeviceIndex(forget_after=1000.0)
    index.observe(FOREIGN)
    entry = index.entry("desk_lamp")
    assert entry is not None
    record = entry_record(entry).replace(',"part_ids":{}', "")
    assert "part_ids" not in record
    again = DeviceIndex(forget_after=1000.0)
    again.restore(read_entry("desk_lamp", record), 1.0)
    assert lamps(again) == ["0x17_light"]


def test_of_two_parts_that_were_thought_to_be_one_that_which_is_called_so_keeps_the_id(index: DeviceIndex) -> None:
    """The other one truly is another part."""
    index.observe(FOREIGN)
    assert lamps(index) == ["0x17_light"]
    index.observe(NATIVE)
    assert lamps(index) == ["0x17_light"]
    plug = part_of("plug", "on_off", id="state", reads=("z",), writes=("z/set",))
    index.observe(announce("0x17", plug, convention="zigbee2mqtt", ids=(IEEE,)))
    (device,) = index.devices()
    assert {one.id: one.part.service_type for one in device.parts} == {"0x17_light": "light", "state": "plug"}


def test_a_new_part_does_not_take_the_id_of_one_that_is_there(index: DeviceIndex) -> None:
    index.observe(announce("a", part_of("contact_sensor", id="x"), ids=(IEEE,)))
    index.devices()
    index.observe(announce("z", part_of("plug", id="x"), convention="zigbee2mqtt", ids=(IEEE,)))
    (device,) = index.devices()
    assert {one.id: one.part.service_type for one in device.parts} == {
        "x": "contact_sensor",
        "zigbee2mqtt:z/x": "plug",
    }


def test_what_is_remembered_of_parts_that_are_gone_is_bounded() -> None:
    known = {("g", "k", str(number)): "other" for number in range(2 * MAX_LOST)}
    lost = lost_ids(known, ())
    assert (len(lost), next(iter(lost))) == (MAX_LOST, ("g", "k", str(MAX_LOST)))
    assert lost_ids({("g", "k", "a"): "a", ("g", "k", "b"): "x"}, [("g", "k", "b")]) is NO_IDS


def the_four() -> tuple[Sighting, ...]:
    """Two conventions about a lamp with a plug, and what each says of it at another time."""

    def lamp(name: str) -> Part:
        return part_of("light", "on_off", id=name, reads=("z",), writes=("z/set",))

    def plug(name: str) -> Part:
        return part_of("plug", "on_off", id=name, reads=("z",), writes=("z/set",))

    return (
        announce("light/0x17", lamp("state"), ids=(IEEE,)),
        announce("plug/0x17", plug("0x17_plug"), ids=(IEEE,)),
        announce("0x17", lamp("light"), plug("state"), convention="zigbee2mqtt", ids=(IEEE,)),
        announce("0x17", plug("light"), convention="zigbee2mqtt", ids=(IEEE,)),
    )


def part_routes(index: DeviceIndex) -> dict[str, frozenset[tuple[str, str]]]:
    """Who tells of each part of the only device."""
    return {
        one.id: frozenset((way.key, way.part) for way in one.routes)
        for device in index.devices()
        for one in device.parts
    }


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from(["says", "says", "is gone", "restart"])), max_size=12))
def test_whatever_is_said_in_whatever_order_a_part_that_stays_one_keeps_its_id(steps: list[tuple[int, str]]) -> None:
    sightings = the_four()
    index = DeviceIndex(forget_after=1000.0)
    for number, what in steps:
        before = part_routes(index)
        if what == "restart":
            index = after_restart(index)
            assert part_routes(index) == before
            continue
        had = {one.id for one in index.devices()}
        index.observe(sightings[number] if what == "says" else gone(sightings[number]))
        now = part_routes(index)
        if not had or not index.devices():
            continue
        for part_id, ways in now.items():
            were = [old for old, old_ways in before.items() if ways & old_ways]
            if len(were) == 1 and sum(bool(before[were[0]] & other) for other in now.values()) == 1:
                assert part_id == were[0]


def after_restart(index: DeviceIndex) -> DeviceIndex:
    again = DeviceIndex(forget_after=1000.0)
    for device in index.devices():
        entry = index.entry(device.id)
        assert entry is not None
        again.restore(read_entry(device.id, entry_record(entry)), 1.0)
    return again


places = st.tuples(st.just("g"), st.sampled_from("kl"), st.sampled_from("ab"))


@given(
    st.lists(st.tuples(st.sampled_from("abc"), st.lists(st.tuples(st.integers(0, 3), places), max_size=3)), max_size=8),
    st.dictionaries(places, st.sampled_from(["a", "b", "l/a"])),
)
def test_ids_are_always_different_and_last(
    parts: list[tuple[str, list[tuple[int, PartPlace]]]], known: dict[PartPlace, str]
) -> None:
    named = [Named(name, "l", places) for name, places in parts]
    ids = part_ids(named, known)
    assert len(set(ids)) == len(ids) == len(parts)
    told = {place: part_id for part, part_id in zip(named, ids, strict=True) for _, place in part.places}
    if len(told) == sum(len(part.places) for part in named):
        assert part_ids(named, told) == ids


@pytest.mark.parametrize("is_alone", [False, True])
def test_a_value_is_told_of_the_part_by_its_id_in_the_device(index: DeviceIndex, *, is_alone: bool) -> None:
    """Whichever of two announcements it came through; also when the one that gave the id is gone."""
    index.changes.collects_states = True
    for one in (FOREIGN, NATIVE, *([gone(FOREIGN)] if is_alone else [])):
        index.observe(one)
        index.pop_changes()
    index.report(tell(NATIVE, "on_off", True, part="state"))
    (change,) = index.pop_states()
    assert [(one.part, one.value.plain()) for one in change.readings] == [("0x17_light", True)]
    assert change.stream.split("\0")[1:] == ["0x17_light", "on_off"]
