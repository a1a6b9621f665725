"""Places files: what one directory exports another one imports, and nothing that is there is lost."""

import json
import string
from collections.abc import Generator, Mapping
from typing import TypeVar

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import LAMP, sighting_of

from homebot.devices import Sighting
from homebot.discovery import DeviceIndex, OwnerFacts
from homebot.discovery.owner_facts import MAX_STATEMENTS
from homebot.discovery.places_exchange import Imported, parse_places
from homebot.errors import ConfigError, RefusedError
from homebot.places import read_places

T = TypeVar("T")

NAMES = st.text(string.printable + "äß客", min_size=1, max_size=12).filter(
    lambda one: one.strip().isprintable() and any(letter.isalnum() for letter in one)
)
ROOMS = st.sampled_from(["Hall", "Kitchen", "Attic", "outside"])
FACTS = st.lists(
    st.one_of(st.tuples(st.just("area"), ROOMS), st.tuples(st.just("name"), NAMES), st.tuples(st.just("tag"), NAMES)),
    max_size=6,
)


def test_a_door_of_a_file_may_lead_to_a_room_that_the_house_has() -> None:
    """One more room, and its door: in GeoJSON the rooms of a line are those at it, also those of the house."""
    square = [[0, 0], [4, 0], [4, 5], [0, 5]]
    house = read_places({"rooms": {"Hall": {"polygon": square}}}, "Home", "homebot.toml", "configuration").rooms
    bath = {"type": "Polygon", "coordinates": [[[0, 5], [4, 5], [4, 8], [0, 8]]]}
    door = {"type": "LineString", "coordinates": [[1, 5], [2, 5]]}
    features = [
        {"type": "Feature", "properties": {"name": "Bath"}, "geometry": bath},
        {"type": "Feature", "properties": {}, "geometry": door},
    ]
    for text in (json.dumps({"features": features}), '[places.rooms.Bath]\ndoors = ["Hall"]'):
        assert [room.name for room in parse_places(text, "Home", 0.0, house).rooms] == ["Bath"]
        with pytest.raises(ConfigError, match=r"Hall|only at Bath"):
            parse_places(text, "Home", 0.0)


def test_a_file_that_is_neither_toml_nor_geojson_is_called_so() -> None:
    with pytest.raises(ConfigError, match=r"is invalid TOML.*GeoJSON would begin with {"):
        parse_places("[" * 20_000, "Home", 0.0)


def done(work: Generator[None, None, T]) -> T:
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def sighting(number: int) -> Sighting:
    return sighting_of(
        f"homeassistant:{number}",
        LAMP,
        convention="homeassistant",
        identifiers=(f"mac:00000000000{number}",),
        area="Study",
        at=1.0,
    )


def house(*numbers: int, table: Mapping[str, object] | None = None) -> DeviceIndex:
    """An index with these lamps, in the order of their coming; all are called alike."""
    places = read_places(table or {}, "Home", "homebot.toml", "configuration")
    index = DeviceIndex(forget_after=1000.0, owner=OwnerFacts("Home", places))
    for number in numbers:
        index.observe(sighting(number), 0.0)
    return index


def export(index: DeviceIndex) -> str:
    return done(index.places_exchange.export_text())


def take(index: DeviceIndex, text: str, *, replaces: bool = False) -> Imported:
    return done(index.places_exchange.apply(parse_places(text, "Home", 9.0), replaces=replaces))


def stated(index: DeviceIndex) -> dict[str, tuple[str, tuple[str, ...], tuple[str, ...]]]:
    """Room, tags and names of each device by its hardware address, in no order."""
    return {
        device.identifiers[0]: (device.area, tuple(sorted(device.tags)), tuple(sorted(device.names)))
        for device in index.devices()
    }


@given(st.lists(FACTS, min_size=3, max_size=3), st.permutations([0, 1, 2]))
def test_what_is_exported_is_the_same_in_another_house_whatever_the_ids_there(
    facts: list[list[tuple[str, str]]], order: list[int]
) -> None:
    index = house(0, 1, 2)
    for device, some in zip(index.devices(), facts, strict=True):
        for name, value in some:
            if name == "area":
                index.places.place(device.id, value, 1.0, is_new=True)
            else:
                index.places.add(device.id, "name" if name == "name" else "tag", value, 1.0)
    text = export(index)
    before = house(*order)
    take(before, text)
    after = house()
    take(after, text)
    for number in order:
        after.observe(sighting(number), 0.0)
    assert stated(before) == stated(after) == stated(index)
    assert take(after, text) == Imported((), ())


def test_a_room_that_was_stated_stays_unless_the_file_is_to_replace_it() -> None:
    index = house(0, table={"rooms": {"Bath": {}}, "devices": {"lamp": {"room": "Bath", "tags": ["a"]}}})
    text = "[places.rooms.Hall]\n[places.devices.lamp]\nroom = 'Hall'\ntags = ['A', 'b']"
    assert take(index, text) == Imported(("room Hall", "lamp"), ("lamp stays in Bath; the file says Hall",))
    assert stated(index) == {"mac:000000000000": ("Bath", ("a", "b"), ("Lamp",))}
    assert take(index, text, replaces=True) == Imported(("lamp",), ())
    assert stated(index) == {"mac:000000000000": ("Hall", ("a", "b"), ("Lamp",))}
    assert index.places.unplace("lamp") == "Bath"


def test_an_import_is_of_a_device_that_went_and_of_no_other_that_was_split_off() -> None:
    index = house(0, 1)
    index.merge([device.id for device in index.devices()], 1.0)
    (merged,) = index.devices()
    index.places.add(merged.id, "tag", "a", 1.0)
    kept, other = index.split(merged.id, None, 2.0)
    index.forget(kept, 3.0)
    take(index, f"[places.devices.'{kept}']\ntags = ['b']")
    index.observe(sighting(0), 4.0)
    assert {device.id: device.tags for device in index.devices()} == {kept: ("a", "b"), other: ("a",)}


def test_devices_hear_of_a_room_that_moved() -> None:
    index = house(0, 1)
    index.places.place("lamp", "Hall", 1.0)
    index.pop_changes()
    take(index, "[places.rooms.hall]\nfloor = 'Downstairs'")
    (change,) = index.pop_changes()
    assert (change.device.id, change.device.outer_areas) == ("lamp", ("Downstairs", "Home"))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[places.rooms.Hall]\nfloor = 'Bath'", "places.rooms.Hall.floor: 'Bath' is a room"),
        ("[places.rooms.Loft]\n[places.rooms.Bath]\nfloor = 'Loft'", "places.rooms.Bath.floor: 'Loft' is a room"),
    ],
)
def test_a_file_that_does_not_fit_the_house_changes_nothing(text: str, problem: str) -> None:
    index = house(0, table={"rooms": {"Bath": {}}})
    before = export(index)
    with pytest.raises(ConfigError) as refused:
        take(index, f"[places.devices.lamp]\ntags = ['a']\n{text}")
    assert f"{refused.value.key}: {refused.value.reason}" == problem
    assert export(index) == before


def test_too_many_statements_are_refused_as_a_whole() -> None:
    owner = OwnerFacts("Home")
    others = [("mqtt", f"other{number}") for number in range(MAX_STATEMENTS - 2)]
    owner.restore(json.dumps({"statements": [{"facts": [], "announcements": others}]}))
    index = DeviceIndex(forget_after=1000.0, owner=owner)
    before = export(index)
    with pytest.raises(RefusedError):
        take(index, "\n".join(f"[places.devices.l{number}]\ntags = ['a']" for number in range(3)))
    assert export(index) == before


@given(st.text(max_size=200) | st.text("[]places.rmdvic='\"{}\n=,#", max_size=200))
def test_any_text_is_taken_over_or_refused_with_a_reason(text: str) -> None:
    index = house(0)
    before = export(index)
    try:
        take(index, text)
    except ConfigError:
        assert export(index) == before
