"""The owner states rooms, aliases and tags of devices: that outranks what they announce, and stays theirs."""

import json
from collections.abc import Mapping
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import LAMP, sighting_of
from tests.discovery.announcements import announce, part_of

from homebot.devices import Device, KeyValue, Sighting
from homebot.devices.client_rights import without_taught_room
from homebot.discovery import DeviceIndex, OwnerFacts
from homebot.discovery.description import MAX_FACTS, position_of
from homebot.discovery.owner_facts import MAX_STATEMENTS
from homebot.errors import RefusedError, UsageError, WireError
from homebot.messages import Time
from homebot.places import HouseRoom, read_places
from homebot.words.queries import parse_query

MAC = "mac:aabbccddeeff"
SERIAL = "id:SN-4711-0815"
ROOMS = {"Hall": {"floor": "Downstairs", "doors": ["Kitchen"]}, "Kitchen": {"floor": "Downstairs"}, "Attic": {}}


def index_of(devices: Mapping[str, object] | None = None) -> DeviceIndex:
    """An index with a table ``[places]``."""
    places = read_places({"rooms": ROOMS, "devices": devices or {}}, "Home", "homebot.toml", "configuration")
    return DeviceIndex(forget_after=1000.0, owner=OwnerFacts("Home", places, 5.0))


def got(index: DeviceIndex, device_id: str) -> Device:
    device = index.get(device_id)
    assert device is not None
    return device


def areas(index: DeviceIndex) -> dict[str, str]:
    return {device.id: device.area for device in index.devices()}


STUDY_LAMP = announce("l", part_of("light", "on_off", id="l"), ids=(MAC,), name="Lamp", area="Study", at=1.0)


@pytest.fixture
def index() -> DeviceIndex:
    """With a lamp in the study."""
    index = index_of()
    index.observe(STUDY_LAMP, 0.0)
    return index


LIGHT = part_of("light", "on_off", id="l")
THREE_WAYS = (
    announce("a", LIGHT, ids=(MAC,), gateway="radio", name="Radio"),
    announce("b", LIGHT, ids=(MAC, SERIAL), gateway="cable", name="Cable"),
    announce("c", LIGHT, ids=(SERIAL,), gateway="web", name="Web"),
)
"""One lamp over three gateways: two name its hardware address, two its serial number."""


def test_a_stated_room_outranks_the_announced_one_and_is_told_with_its_source(index: DeviceIndex) -> None:
    index.pop_changes()
    assert index.places.place("lamp", "kitchen", 7.0) == "Kitchen"
    device = got(index, "lamp")
    assert (device.area, device.outer_areas) == ("Kitchen", ("Downstairs", "Home"))
    assert [(one.value, one.convention, one.key, one.gateway) for one in device.facts if one.name == "area"] == [
        ("Kitchen", "owner", "command", ""),
        ("Study", "homeassistant", "homeassistant:l", "mqtt"),
    ]
    assert device.facts[0].said_at == Time.from_seconds(7.0)
    (change,) = index.pop_changes()
    assert (change.kind, change.why, change.device) == ("changed", "the owner placed it in Kitchen", device)
    assert index.places.unplace("lamp") == "Study"
    assert got(index, "lamp").outer_areas == ("Home",)


def test_a_device_known_by_one_of_its_stated_names_is_not_absent() -> None:
    """The others may never be announced."""
    index = index_of({"lamp": {"identifiers": [MAC, SERIAL], "room": "Hall"}})
    assert list(index.places.absent()) == [(MAC, "Hall")]
    index.observe(STUDY_LAMP, 0.0)
    assert list(index.places.absent()) == []


def test_an_announced_floor_has_its_rooms_until_the_owner_states_another() -> None:
    light, upstairs = part_of("light", "on_off"), {"floor": "Upstairs"}
    index = index_of()
    index.observe(announce("l", light, name="Lamp", area="Study", facts=upstairs), 0.0)
    index.observe(announce("m", light, name="Other", area="Kitchen", facts=upstairs), 0.0)
    index.sort()
    assert got(index, "lamp").outer_areas == ("Upstairs", "Home")
    assert got(index, "other").outer_areas == ("Downstairs", "Home")
    for query in ("light in upstairs", "floor=Upstairs", "upstairs"):
        assert index.find(parse_query(query)) == {"lamp"}
    index.places.place("lamp", "study", 1.0)
    assert (got(index, "lamp").area, got(index, "lamp").outer_areas) == ("study", ("Upstairs", "Home"))
    index.places.place("lamp", "Attic", 2.0)
    assert got(index, "lamp").outer_areas == ("Home",)


def test_what_a_tag_taught_is_listed_after_what_the_device_announces(index: DeviceIndex) -> None:
    index.places.teach("lamp", "nfc", "", "Hall", 2.0)
    index.places.add("lamp", "tag", "night", 3.0)
    facts = got(index, "lamp").facts
    assert [(one.value, one.convention) for one in facts if one.name in {"area", "tag"}] == [
        ("night", "owner"),
        ("Study", "homeassistant"),
        ("Hall", "tag"),
    ]
    index.places.place("lamp", "Kitchen", 4.0)
    assert [one.value for one in got(index, "lamp").facts if one.name == "area"] == ["Kitchen", "Study", "Hall"]


def test_however_much_a_device_announces_it_stays_known_that_a_tag_taught_its_room() -> None:
    index = index_of()
    said = {f"k{number}": "x" for number in range(MAX_FACTS)}
    index.observe(announce("l", part_of("light", "on_off", id="l"), name="Lamp", facts=said))
    index.places.teach("lamp", "nfc", "", "Hall", 2.0)
    assert len(got(index, "lamp").facts) == MAX_FACTS
    assert without_taught_room(got(index, "lamp")).area == ""


def test_aliases_and_tags_add_up_and_are_taken_back(index: DeviceIndex) -> None:
    index.places.add("lamp", "name", "Reading lamp", 1.0)
    assert index.places.add("lamp", "name", "Corner lamp", 2.0) == ("Corner lamp", "Reading lamp")
    assert index.places.add("lamp", "tag", "night", 3.0) == ("night",)
    assert index.places.add("lamp", "tag", "Night", 4.0) == ("Night",)
    device = got(index, "lamp")
    assert (device.name, device.names, device.tags) == (
        "Corner lamp",
        ("Corner lamp", "Reading lamp", "Lamp"),
        ("Night",),
    )
    assert index.places.withdraw("lamp", "name", "CORNER LAMP") == ("Reading lamp",)
    assert index.places.withdraw("lamp", "tag", "night") == ()
    assert got(index, "lamp").name == "Reading lamp"


@pytest.mark.parametrize(
    "text",
    [
        "in downstairs",
        "in Hall",
        "in home",
        "light downstairs",
        "floor=downstairs",
        "tag=night-light",
        "night",
        "alias='Corner lamp'",
        "corner",
        "with area",
        "light without area or tag='night light'",
        "convention=owner",
    ],
)
def test_every_query_knows_rooms_floors_aliases_and_tags(text: str) -> None:
    index = index_of()
    for key in ("a", "b"):
        index.observe(
            announce(key, part_of("light", "on_off", id="l"), ids=(f"mac:0000000000{key}{key}",), name=key), 0.0
        )
    index.places.place("a", "Hall", 1.0)
    index.places.add("a", "name", "Corner lamp", 1.0)
    index.places.add("a", "tag", "Night light", 1.0)
    found = index.find(parse_query(text))
    assert found == ({"a", "b"} if "without" in text else {"a"})


def test_a_device_without_a_room_is_found_so(index: DeviceIndex) -> None:
    index.observe(announce("n", name="Nowhere", ids=("mac:000000000001",)), 0.0)
    assert index.find(parse_query("without area")) == {"nowhere"}
    index.places.place("nowhere", "Attic", 1.0)
    assert index.find(parse_query("without room")) == set()


def test_the_configuration_is_there_before_the_device() -> None:
    index = index_of({"lamp": {"room": "hall", "aliases": ["Big lamp", "Old lamp"], "tags": ["night"]}})
    index.observe(STUDY_LAMP, 0.0)
    device = got(index, "lamp")
    assert (device.area, device.name, device.tags) == ("Hall", "Big lamp", ("night",))
    assert {(one.key, one.said_at.to_seconds()) for one in device.facts if one.convention == "owner"} == {
        ("configuration", 5.0)
    }


def test_the_configuration_knows_devices_by_hardware_address() -> None:
    by_id: Mapping[str, object] = {"another id": {"room": "Hall", "identifiers": [MAC]}}
    for devices in ({MAC: {"room": "Hall"}}, by_id):
        index = index_of(devices)
        index.observe(STUDY_LAMP, 0.0)
        assert got(index, "lamp").area == "Hall"


def test_a_command_outranks_the_configuration_until_it_is_taken_back() -> None:
    index = index_of({"lamp": {"room": "Hall", "aliases": ["Big lamp"], "tags": ["night"]}})
    index.observe(STUDY_LAMP, 0.0)
    index.places.place("lamp", "Kitchen", 1.0)
    index.places.add("lamp", "name", "My lamp", 1.0)
    device = got(index, "lamp")
    assert (device.area, device.names) == ("Kitchen", ("My lamp", "Big lamp", "Lamp"))
    assert index.places.unplace("lamp") == "Hall"
    with pytest.raises(RefusedError, match="'Hall' is stated in the configuration"):
        index.places.unplace("lamp")
    with pytest.raises(RefusedError, match="'night' is stated in the configuration"):
        index.places.withdraw("lamp", "tag", "night")
    with pytest.raises(RefusedError, match="no command gave it to lamp, which has night"):
        index.places.withdraw("lamp", "tag", "day")


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_the_owner_outranks_whatever_is_announced_in_whatever_order(order: tuple[int, ...]) -> None:
    index = index_of({MAC: {"room": "Hall"}})
    for number in order:
        sighting = THREE_WAYS[number].model_copy(update={"area": f"Room {number}"})
        index.observe(sighting, 0.0)
    (device,) = index.devices()
    assert device.area == "Hall"
    index.places.place(device.id, "Attic", 1.0)
    for one in THREE_WAYS:
        index.observe(one.model_copy(update={"area": "Garage", "metadata": ()}), 2.0)
    assert [one.area for one in index.devices()] == ["Attic"]


def test_a_merged_device_is_where_the_later_statement_put_it_and_each_returns_to_its_own() -> None:
    index = index_of()
    for one in THREE_WAYS[::2]:
        index.observe(one, 0.0)
    index.places.place("radio", "Hall", 1.0)
    index.places.place("web", "Kitchen", 2.0)
    index.places.add("radio", "tag", "night", 3.0)
    index.merge(("radio", "web"), 4.0)
    device = got(index, "radio")
    assert (device.area, device.tags) == ("Kitchen", ("night",))
    index.split("radio", None, 5.0)
    assert areas(index) == {"radio": "Hall", "web": "Kitchen"}
    assert got(index, "web").tags == ()


def test_a_statement_on_a_merged_device_is_of_both_after_a_split() -> None:
    index = index_of()
    for one in THREE_WAYS:
        index.observe(one, 0.0)
    index.places.place("radio", "Hall", 1.0)
    index.split("radio", None, 2.0)
    assert areas(index) == {"radio": "Hall", "cable": "Hall", "web": "Hall"}
    index.places.place("cable", "Kitchen", 3.0)
    index.places.unplace("web")
    assert areas(index) == {"radio": "Hall", "cable": "Kitchen", "web": ""}


def test_what_was_taken_back_of_a_merged_device_does_not_return_with_a_split() -> None:
    index = index_of()
    for one in THREE_WAYS[::2]:
        index.observe(one, 0.0)
    index.places.place("web", "Kitchen", 2.0)
    index.merge(("radio", "web"), 4.0)
    index.places.unplace("radio")
    index.split("radio", None, 5.0)
    assert areas(index) == {"radio": "", "web": ""}


def test_the_configuration_of_a_device_stays_with_it_when_it_is_merged_into_an_older_one() -> None:
    index = index_of({"web": {"room": "Hall"}})
    index.observe(THREE_WAYS[0], 0.0)
    index.observe(THREE_WAYS[2], 0.0)
    index.merge(("radio", "web"), 1.0)
    assert areas(index) == {"radio": "Hall"}
    again = restored(index, {"web": {"room": "Hall"}})
    assert areas(again) == {"radio": "Hall"}
    again.split("radio", None, 2.0)
    assert areas(again) == {"radio": "", "web": "Hall"}


def restored(index: DeviceIndex, devices: Mapping[str, object] | None = None) -> DeviceIndex:
    """A new index with what the file would have."""
    again = index_of(devices)
    again.decisions.restore(index.decisions.record())
    again.owner.restore(index.owner.record())
    for device in index.devices():
        entry = index.entry(device.id)
        assert entry is not None
        again.restore(entry, 0.0)
    return again


def test_a_statement_survives_a_restart_and_a_device_that_goes_and_returns(index: DeviceIndex) -> None:
    index.places.place("lamp", "Hall", 1.0)
    index.places.add("lamp", "tag", "night", 2.0)
    assert index.owner.is_unsaved
    again = restored(index)
    assert (got(again, "lamp").area, got(again, "lamp").tags) == ("Hall", ("night",))
    again.forget("lamp", 3.0)
    assert not again.devices()
    again.observe(STUDY_LAMP.model_copy(update={"key": "homeassistant:new", "confirmed": True}), 4.0)
    assert areas(again) == {"lamp": "Hall"}


def test_a_statement_stays_when_the_announcement_that_it_was_made_on_is_withdrawn(index: DeviceIndex) -> None:
    index.places.place("lamp", "Hall", 1.0)
    index.observe(STUDY_LAMP.model_copy(update={"key": "homeassistant:second"}), 2.0)
    index.observe(STUDY_LAMP.model_copy(update={"kind": "removed"}), 3.0)
    assert areas(index) == {"lamp": "Hall"}


def test_what_was_taken_back_does_not_return_with_an_announcement_that_was_withdrawn(index: DeviceIndex) -> None:
    index.observe(STUDY_LAMP.model_copy(update={"key": "homeassistant:second"}), 0.0)
    index.places.place("lamp", "Hall", 1.0)
    index.observe(STUDY_LAMP.model_copy(update={"kind": "removed"}), 2.0)
    index.places.unplace("lamp")
    index.observe(STUDY_LAMP, 3.0)
    assert areas(index) == {"lamp": "Study"}


def test_what_is_taken_back_of_one_stays_with_the_other_that_was_split_off_and_is_away() -> None:
    index = index_of()
    for one in THREE_WAYS:
        index.observe(one, 0.0)
    index.places.place("radio", "Hall", 1.0)
    index.split("radio", None, 2.0)
    index.forget("web", 3.0)
    index.places.unplace("radio")
    index = restored(index)
    index.observe(THREE_WAYS[2].model_copy(update={"confirmed": True}), 4.0)
    assert areas(index) == {"radio": "", "cable": "Hall", "web": "Hall"}


def test_a_room_one_typo_away_from_another_is_taken_for_a_typo_unless_it_is_said_to_be_new(index: DeviceIndex) -> None:
    with pytest.raises(UsageError, match=r"there is no room 'Kichen'; did you mean Kitchen\?"):
        index.places.place("lamp", "Kichen", 1.0)
    index.sort()
    with pytest.raises(UsageError, match=r"did you mean Study\?"):
        index.places.place("lamp", "Studyy", 1.0)
    assert index.places.place("lamp", "Kichen", 1.0, is_new=True) == "Kichen"
    assert index.places.place("lamp", "Garage", 1.0) == "Garage"
    assert index.places.place("lamp", "garage", 1.0) == "garage"
    assert index.places.place("lamp", "downstairs", 1.0) == "Downstairs"
    assert got(index, "lamp").outer_areas == ("Home",)


def test_a_room_is_called_as_the_devices_that_are_in_it_spell_it() -> None:
    """`place lamp Hall` and `place motion hall` made two rooms of the page and of the API."""
    index = index_of()
    for one in THREE_WAYS:
        index.observe(one, 0.0)
    index.split("radio", None, 1.0)
    assert index.places.place("radio", "Hall", 2.0) == "Hall"
    index.sort()
    assert index.places.place("web", "hall", 3.0) == "Hall"


@pytest.mark.parametrize(
    ("name", "reason"),
    [("", "is empty"), ("x" * 101, "100 is the limit"), ("a\nb", "an unprintable character"), ("--", "no letter")],
)
def test_a_name_that_cannot_be_one_is_refused(index: DeviceIndex, name: str, reason: str) -> None:
    for state in (index.places.place, lambda *args: index.places.add(args[0], "tag", *args[1:])):
        with pytest.raises(UsageError, match=reason):
            state("lamp", name, 1.0)
    with pytest.raises(RefusedError, match="there is no device"):
        index.places.place("nobody", "Hall", 1.0)


def test_statements_are_bounded() -> None:
    owner = OwnerFacts("Home")
    others = [("mqtt", f"other{number}") for number in range(MAX_STATEMENTS - 2)]
    owner.restore(json.dumps({"statements": [{"facts": [], "announcements": others}]}))
    index = DeviceIndex(forget_after=1000.0, owner=owner)
    index.observe(STUDY_LAMP, 0.0)
    index.places.place("lamp", "Hall", 1.0)
    index.observe(
        STUDY_LAMP.model_copy(update={"key": "homeassistant:o", "identifiers": ("mac:1",), "name": "Other"}), 0.0
    )
    with pytest.raises(RefusedError, match="take some back"):
        index.places.place("other", "Hall", 1.0)
    index.places.place("lamp", "Kitchen", 1.0)
    index.places.unplace("lamp")
    index.places.place("other", "Hall", 1.0)
    assert areas(index) == {"lamp": "Study", "other": "Hall"}


def test_a_device_has_at_most_fifty_tags(index: DeviceIndex) -> None:
    for number in range(50):
        index.places.add("lamp", "tag", f"tag {number}", 1.0)
    with pytest.raises(RefusedError, match="has 50 already"):
        index.places.add("lamp", "tag", "one more", 1.0)


@pytest.mark.parametrize("record", ["", "[]", '{"statements": 3}', '{"statements": [{"facts": [{"name": "colour"}]}]}'])
def test_a_broken_record_is_refused(record: str) -> None:
    with pytest.raises(WireError):
        OwnerFacts().restore(record)


def test_an_imported_room_that_fits_no_more_stays_in_the_record() -> None:
    index = index_of()
    index.owner.import_rooms((HouseRoom("Upstairs"), HouseRoom("Loft", "Top")), "a file")
    owner = OwnerFacts("Home", read_places({"rooms": {"Bath": {"floor": "Upstairs"}}}, "Home", "", "configuration"))
    with pytest.raises(WireError, match=r"places\.rooms"):
        owner.restore(index.owner.record())
    assert [room.name for room in owner.plan.rooms] == ["Bath", "Loft"]
    other = OwnerFacts("Home")
    other.restore(owner.record())
    assert [room.name for room in other.plan.rooms] == ["Upstairs", "Loft"]


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("observe"), st.integers(0, 2), st.sampled_from(["", "Garage", "Bath"])),
        st.tuples(st.just("withdraw"), st.integers(0, 2), st.just("")),
        st.tuples(st.just("restart"), st.just(0), st.just("")),
        st.tuples(st.just("split"), st.just(0), st.just("")),
    ),
    max_size=12,
)


def sighting(number: int, area: str, kind: str) -> Sighting:
    return sighting_of(
        f"homeassistant:{number}",
        LAMP,
        gateway=("radio", "cable", "web")[number],
        kind="removed" if kind == "withdraw" else "updated",
        convention="homeassistant",
        identifiers=((MAC,), (MAC, SERIAL), (SERIAL,))[number],
        area=area,
        confirmed=False,
        at=1.0,
    )


@given(STEPS, STEPS)
def test_what_the_owner_stated_of_all_outranks_every_later_announcement(
    before: list[tuple[str, int, str]], after: list[tuple[str, int, str]]
) -> None:
    index = index_of()
    for steps in (before, after):
        for step, number, area in steps:
            if step in {"observe", "withdraw"}:
                index.observe(sighting(number, area, step), 1.0)
            elif step == "restart":
                index = restored(index)
            else:
                for device in index.devices():
                    if device.evidence:
                        index.split(device.id, None, 1.0)
        if steps is before:
            for number in range(3):
                index.observe(sighting(number, "", "observe"), 1.0)
            for device in index.devices():
                index.places.place(device.id, "Attic", 2.0)
                index.places.add(device.id, "tag", "night", 2.0)
    assert {(device.area, device.tags) for device in index.devices()} <= {("Attic", ("night",))}


AREAS = {
    "Hall": {"polygon": [[0, 0], [4, 0], [4, 5], [0, 5]]},
    "Kitchen": {"polygon": [[4, 0], [8, 0], [8, 5], [4, 5]]},
}


def with_areas() -> DeviceIndex:
    return DeviceIndex(forget_after=1000.0, owner=OwnerFacts("Home", read_places({"rooms": AREAS}, "Home", "x", "x")))


def positions(index: DeviceIndex, device_id: str) -> list[tuple[float, float, float, str]]:
    found = position_of(got(index, device_id).facts)
    return [] if found is None else [(found.x, found.y, found.error, found.source)]


@pytest.mark.parametrize(
    ("fact", "stated", "error"),
    [
        ("position", "6,1", 2.0),  # a Thing Description's homebot:facts
        ("txt_position", "6,1", 2.0),  # DNS-SD's TXT
        ("position", "6.0,1.0 ±0.25 m", 0.25),
    ],
)
def test_a_device_that_announces_its_position_is_in_the_room_that_is_there(
    fact: str, stated: str, error: float
) -> None:
    index = with_areas()
    light = part_of("light", "on_off", id="l")
    index.observe(announce("l", light, name="Lamp", convention="thing", facts={fact: stated}))
    assert got(index, "lamp").area == "Kitchen"
    assert positions(index, "lamp") == [(6.0, 1.0, error, "thing")]
    assert index.places.place("lamp", "", 3.0, at="1,1") == "Hall"
    assert positions(index, "lamp") == [(1.0, 1.0, 0.1, "command")]
    assert index.places.unplace("lamp") == "Kitchen"


def test_an_announced_room_outranks_the_room_at_an_announced_position() -> None:
    index = with_areas()
    index.observe(STUDY_LAMP.model_copy(update={"metadata": (KeyValue(key="position", value="6,1"),)}))
    assert got(index, "lamp").area == "Study"


def test_an_announced_word_that_is_no_position_is_passed_over() -> None:
    index = with_areas()
    index.observe(announce("l", part_of("light", "on_off", id="l"), name="Lamp", facts={"position": "left"}))
    assert (got(index, "lamp").area, positions(index, "lamp")) == ("", [])


def test_a_tag_teaches_its_own_position() -> None:
    index = with_areas()
    index.observe(announce("l", part_of("light", "on_off", id="l"), name="Lamp"))
    index.observe(announce("t", part_of("x_tag", id="t"), name="Tag", gateway="nfc"))
    index.places.place("tag", "", 1.0, at="6,1")

    assert index.places.teach("lamp", "nfc", "homeassistant:t", "", 2.0) == ("Kitchen", True)
    assert index.places.teach("lamp", "nfc", "homeassistant:t", "", 3.0) == ("Kitchen", False)

    assert positions(index, "lamp") == [(6.0, 1.0, 0.3, "tag")]
    assert [(one.value, one.convention, one.gateway) for one in got(index, "lamp").facts if one.name == "position"] == [
        ("6,1 ±0.3 m", "tag", "nfc")
    ]
    assert without_taught_room(got(index, "lamp")).area == ""
    assert index.places.place("lamp", "", 4.0, at="1,1") == "Hall"
    assert without_taught_room(got(index, "lamp")).area == "Hall"
    restored = OwnerFacts("Home")
    restored.restore(index.owner.record())
    index.places.unplace("lamp")
    assert index.places.unplace("lamp") == ""
    assert positions(index, "lamp") == []
