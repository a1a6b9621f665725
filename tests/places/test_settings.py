"""The table ``[places]``, and the text of a places file."""

import pytest

from homebot.errors import ConfigError
from homebot.places import HousePlan, HouseRoom, OwnerFact, places_text, read_places, stated_position
from homebot.support.toml_file import parse_toml

TEXT = """\
[places.rooms]
Hall = { floor = "Downstairs", doors = ["Kitchen", "outside"] }
Kitchen = {}

[places.devices]
"lights/lamp" = { room = "hall", aliases = ["Big lamp", "big-lamp"], tags = ["night", "guests"] }
"other" = { identifiers = ["mac:aa", "id:7"], tags = ["x"] }
"away" = {}
"""


def test_a_position_in_a_house_with_one_floor_is_on_it_also_when_a_second_one_comes() -> None:
    square = ((((0.0, 0.0), (4.0, 0.0), (4.0, 5.0)),),)
    plan = HousePlan("Home", [HouseRoom("Hall", "Ground", polygons=square)])

    assert stated_position("3,1", plan) == "3,1,Ground ±0.1 m"
    assert stated_position("3,1", plan.with_rooms([HouseRoom("Bath", "Top", polygons=square)], "x")) == "3,1 ±0.1 m"


def table(text: str) -> dict[str, object]:
    places = parse_toml(text, "homebot.toml")["places"]
    assert isinstance(places, dict)
    return places


def test_rooms_and_facts_are_read() -> None:
    places = read_places(table(TEXT), "Home", "homebot.toml", "import", 3.0)
    assert places.rooms == (HouseRoom("Hall", "Downstairs", ("Kitchen", "outside")), HouseRoom("Kitchen"))
    assert places.devices == {
        ("lights/lamp",): (
            OwnerFact("area", "Hall", "import", 3.0),
            OwnerFact("name", "Big lamp", "import", 3.0),
            OwnerFact("tag", "night", "import", 3.0),
            OwnerFact("tag", "guests", "import", 3.0),
        ),
        ("mac:aa", "id:7"): (OwnerFact("tag", "x", "import", 3.0),),
        ("away",): (),
    }


@pytest.mark.parametrize(
    ("text", "key", "reason"),
    [
        ("rooms.Hall.flor = 'x'", "places.rooms.Hall.flor", "unknown key; did you mean floor?"),
        ("rooms.Hall.floor = 3", "places.rooms.Hall.floor", "got 3"),
        ("rooms.Hall.doors = ['Kichen']\nrooms.Kitchen = {}", "places.rooms.Hall.doors", "no room 'Kichen'"),
        ("rooms.Hall.doors = ['']\nrooms.Kitchen = {}", "places.rooms.Hall.doors.0", "a name is empty"),
        ("rooms.'' = {}", "places.rooms.", "a name is empty"),
        ("rooms.Hall = {}\nrooms.hall = {}", "places.rooms.hall", "is the same room as 'Hall'"),
        ("rooms.Home = {}", "places.rooms.Home", "is the name of the home"),
        ("rooms.Hall = {}\ndevices.lamp.room = 'Hal'", "places.devices.lamp.room", "there is no room 'Hal'; did you"),
        ("devices.lamp.tags = ['a\\u0007']", "places.devices.lamp.tags.0", "contains an unprintable character"),
        (f"devices.lamp.tags = {['x'] * 51}", "places.devices.lamp.tags", "at most 50"),
        (f"devices.lamp.room = '{'x' * 101}'", "places.devices.lamp.room", "101 characters"),
        ("devices.' '.room = 'x'", "places.devices. ", "the id is empty"),
        ("devices.a.identifiers = ['i']\ndevices.b.identifiers = ['i']", "places.devices.b", "'i' is the device 'a'"),
        ("devices.a.identifiers = ['b']\ndevices.b.room = 'Hall'", "places.devices.b", "'b' is the device 'a'"),
    ],
)
def test_a_mistake_is_named_by_key_and_value(text: str, key: str, reason: str) -> None:
    with pytest.raises(ConfigError) as refused:
        read_places(table(f"[places]\n{text}".replace("'a\\u0007'", '"a\\u0007"')), "Home", "homebot.toml", "import")
    assert (refused.value.source, refused.value.key) == ("homebot.toml", key)
    assert reason in refused.value.reason


def test_a_written_file_is_read_as_it_was() -> None:
    rooms = HousePlan("Home", (HouseRoom('Room "1"', "Ground", ("Küche\\", "outside")), HouseRoom("Küche\\"))).rooms
    facts = (
        OwnerFact("area", "Attic", "import", 0.0),
        OwnerFact("name", "Lämp ' \x7f".replace("\x7f", "7"), "import", 0.0),
        OwnerFact("tag", "a.b", "import", 0.0),
    )
    text = places_text(HousePlan("Home", rooms), [("lights/lamp", facts, ("mac:aa",)), ("other\x7f", facts[:1], ())])
    assert text.count("doors") == 1
    read = read_places(table(text), "Home", "a file", "import")
    assert HousePlan("Home", read.rooms).rooms == (*rooms, HouseRoom("Attic"))
    assert read.devices == {("mac:aa",): facts, ("other\x7f",): facts[:1]}


def test_half_a_surrogate_pair_is_written_as_a_question_mark() -> None:
    text = places_text(HousePlan("Home"), [("lamp\ud800", (OwnerFact("tag", "x", "command", 0.0),), ())])
    assert '"lamp?"' in text


def test_the_name_of_the_home_is_readable_in_the_file() -> None:
    assert places_text(HousePlan("Ümläut 🏠")).startswith("# Rooms and devices of Ümläut 🏠, for ")
