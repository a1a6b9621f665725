"""``homebot place``, ``alias``, ``tag add`` and ``places``, against the services of a real directory."""

import io
import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from tests.announcements import LAMP, sighting_of
from tests.cli.conftest import NOW, Homebot, HomebotWith, Run, run_at

from homebot.clock import ManualClock
from homebot.devices import Sighting
from homebot.discovery import DeviceIndex, OwnerFacts
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.services import DirectoryServices
from homebot.graph import Graph, Node
from homebot.places import read_places
from homebot.places.plan import door_name

TABLE = {
    "rooms": {"Hall": {"floor": "Downstairs", "doors": ["Kitchen"]}, "Kitchen": {"floor": "Downstairs"}},
    "devices": {"desk_lamp": {"tags": ["warm"]}},
}


def sighting(number: int, name: str, area: str) -> Sighting:
    return sighting_of(
        f"homeassistant:{number}",
        LAMP,
        name=name,
        convention="homeassistant",
        identifiers=(f"mac:00000000000{number}",),
        area=area,
        at=NOW,
    )


@pytest.fixture
def index() -> DeviceIndex:
    places = read_places(TABLE, "home425", "homebot.toml", "configuration")
    return DeviceIndex(forget_after=1000.0, owner=OwnerFacts("home425", places, NOW - 60))


DEVICES = (("Desk lamp", "Study"), ("Ceiling", ""))


def index_node(index: DeviceIndex, graph: Graph, devices: Sequence[tuple[str, str]] = DEVICES) -> Node:
    node = Node(graph, "discovery")
    for number, (name, area) in enumerate(devices):
        index.observe(sighting(number, name, area), NOW)
    persistence = IndexPersistence(node, index, None)
    DirectoryServices(node, index, persistence, lambda at_most: len(index.pop_changes(at_most)) >= at_most).register()
    return node


@pytest.fixture
def placed(homebot_with: HomebotWith, index: DeviceIndex) -> Homebot:
    return homebot_with(partial(index_node, index), ManualClock(NOW))


@pytest.fixture
def run(placed: Homebot, capsys: pytest.CaptureFixture[str]) -> Run:
    return run_at(placed, capsys)


def test_a_device_is_placed_and_the_place_is_taken_back(run: Run) -> None:
    assert run("place", "Desk lamp", "kitchen") == (0, "desk_lamp is in Kitchen now\n")
    code, shown = run("show", "desk lamp")
    assert code == 0
    assert "  area          Kitchen (Downstairs, home425)\n  tags          warm\n" in shown
    facts = [" ".join(line.split()) for line in shown.partition("\nfacts\n")[2].partition("\n\n")[0].splitlines()]
    assert facts == [
        "area Kitchen by the owner now",
        "tag warm by the owner, in the configuration 1 min ago",
        "name Desk lamp via mqtt as homeassistant:0 now",
        "area Study via mqtt as homeassistant:0 now",
    ]
    assert run("find", "light in downstairs")[0] == 0
    assert run("place", "Desk lamp", "--undo") == (0, "desk_lamp is in Study now\n")
    assert run("place", "ceiling", "Attic") == (0, "ceiling is in Attic now\n")
    assert run("place", "ceiling", "--undo") == (0, "the room of ceiling is unknown now\n")


def test_the_name_of_a_person_and_of_her_phone_means_the_person(
    homebot_with: HomebotWith, capsys: pytest.CaptureFixture[str]
) -> None:
    index = DeviceIndex(forget_after=1000.0)
    for kind in ("x_tracker", "x_person"):
        part = LAMP.model_copy(update={"service_type": kind})
        index.observe(sighting_of(f"people:{kind}", part, name="Anna", convention="people", at=NOW), NOW)
    run = run_at(homebot_with(partial(index_node, index), ManualClock(NOW)), capsys)
    code, shown = run("show", "Anna")
    assert (code, "type          person\n" in shown) == (0, True), shown


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("place", "Desk lamp"), "give either a ROOM, --at, or both, or --undo"),
        (("place", "Desk lamp", "Hall", "--undo"), "give either a ROOM, --at, or both, or --undo"),
        (("place", "Desk lamp", "--undo"), "no command stated the room of desk_lamp"),
        (("place", "Desk lamp", "Kichen"), "no room 'Kichen'; did you mean Kitchen? For another room, add --new"),
        (("place", "Desk lamp", "Hal"), "there is no room 'Hal'; did you mean Hall? For another room, add --new"),
        (("alias", "Desk lamp", "  "), "a name is empty"),
        (("alias", "Desk lamp", "CEILING"), "the alias 'CEILING' was refused: ceiling is called that already"),
        (("alias", "Desk lamp", "Bright", "--undo"), "no command gave it to desk_lamp, which has none"),
        (("tag", "remove", "Desk lamp", "warm"), "'warm' is stated in the configuration"),
        (("places", "import", "/nowhere/house.toml"), "/nowhere/house.toml cannot be read: No such file"),
        (("places", "export", "/nowhere/house.toml"), "/nowhere/house.toml cannot be written: No such file"),
    ],
)
def test_a_mistake_is_told(run: Run, arguments: tuple[str, ...], problem: str) -> None:
    code, printed = run(*arguments)
    assert code == 1
    assert printed.startswith("homebot: ")
    assert problem in printed


def test_a_room_with_a_name_like_another_can_be_new(run: Run) -> None:
    assert run("place", "Desk lamp", "Kichen", "--new") == (0, "desk_lamp is in Kichen now\n")


def test_a_device_that_is_to_come_is_placed_when_it_appears(placed: Homebot, index: DeviceIndex, run: Run) -> None:
    told = "there is no device Garden lamp yet; garden_lamp will be in Terrace when it appears\n"
    assert run("place", "Garden lamp", "Terrace") == (0, told)
    code, problem = run("place", "Desk lmp", "Hall")
    assert code == 1
    assert "there is no device Desk lmp; did you mean Desk lamp" in problem
    assert "add --new" in problem
    assert "did you mean Desk lamp" in run("place", "DESK_LMP", "Hall")[1]
    assert run("place", "Desk lmp", "Hall", "--new")[0] == 0
    assert run("place", "mac:000000000008", "kitchen")[1].endswith(
        "mac:000000000008 will be in Kitchen when it appears\n"
    )
    assert run("places", "list")[1].partition("placed, but absent:\n")[2].split() == [
        *("desk_lmp", "Hall", "garden_lamp", "Terrace", "mac:000000000008", "Kitchen")
    ]
    assert run("place", "Desk lmp", "--undo")[1].endswith("desk_lmp will be in no stated room\n")
    assert run("place", "Desk lmp", "--undo")[0] == 1
    for number, name in ((7, "Garden lamp"), (8, "Plug")):
        placed.do(partial(index.observe, sighting(number, name, "Attic"), NOW))
    assert "area          Terrace (home425)" in run("show", "Garden lamp")[1]
    assert "area          Kitchen (Downstairs, home425)" in run("show", "Plug")[1]
    assert "not there yet" not in run("places", "list")[1]


def test_an_imported_room_is_renamed_and_removed(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "house.toml"
    file.write_text(
        '[places.rooms]\nAttic = { floor = "Top", doors = ["Loft"] }\nLoft = {}\n'
        '[places.devices.shed]\nroom = "Attic"\n'
    )
    assert run("places", "import", str(file))[0] == 0
    run("place", "ceiling", "attic")
    assert run("places", "rename", "attic", "Guest room") == (0, "attic is called Guest room now\n")
    assert "Guest room (Top, home425)" in run("show", "ceiling")[1]
    listed = run("places", "list")[1]
    assert "Attic" not in listed
    assert ["shed", "Guest", "room"] in [line.split() for line in listed.splitlines()]
    assert ["Loft", "Guest", "room", "0"] in [line.split() for line in listed.splitlines()]
    code, problem = run("places", "remove", "Guest room")
    assert (code, "devices were placed in it: ceiling, shed; place them elsewhere first" in problem) == (1, True)
    run("place", "ceiling", "--undo")
    run("place", "shed", "--undo")
    assert run("places", "remove", "guest room") == (0, "guest room is removed\n")
    assert [line.split() for line in run("places", "list")[1].splitlines() if "Loft" in line] == [["Loft", "0"]]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("remove", "Hall"), "it is stated in the configuration; change [places] there"),
        (("rename", "Hall", "Lobby"), "it is stated in the configuration; change [places] there"),
        (("remove", "Nowhere"), "no import stated it"),
        (("rename", "Attik", "Top"), "no import stated it; did you mean Attic?"),
        (("rename", "Attic", "Kitchen"), "there is a room 'Kitchen' already"),
        (("rename", "Attic", "Downstairs"), "'Downstairs' is a room"),
        (("rename", "Attic", "  "), "a name is empty"),
    ],
)
def test_a_room_that_cannot_be_changed_stays(
    run: Run, tmp_path: Path, arguments: tuple[str, ...], problem: str
) -> None:
    file = tmp_path / "house.toml"
    file.write_text("[places.rooms.Attic]\n")
    run("places", "import", str(file))
    before = run("places", "list")
    code, told = run("places", *arguments)
    assert code == 1
    assert problem in told
    assert run("places", "list") == before


def test_a_room_of_placed_devices_is_renamed(run: Run) -> None:
    run("place", "ceiling", "Attic")
    assert run("places", "rename", "Attic", "attic") == (0, "Attic is called attic now\n")
    assert run("places", "rename", "Attic", "Loft") == (0, "Attic is called Loft now\n")
    assert "Loft (home425)" in run("show", "ceiling")[1]


def test_who_renames_a_room_is_told_of_the_devices_that_announce_it(run: Run) -> None:
    run("place", "ceiling", "Study")
    assert run("places", "rename", "Study", "Office") == (
        0,
        "Study is called Office now\n"
        "devices that announce Study stay there until `homebot place` moves them: desk_lamp\n",
    )
    assert "Office (home425)" in run("show", "ceiling")[1]


def test_a_search_for_a_room_in_a_house_without_rooms_leads_to_homebot_place(run_with: Callable[..., Run]) -> None:
    run = run_with(partial(index_node, DeviceIndex(forget_after=1000.0), devices=[("Lamp", "")]))
    hint = "state the room of a device with `homebot place DEVICE ROOM`"
    assert run("find", "light in kichen") == (1, f"no device is in 'kichen'; {hint}\n")


def test_a_device_gets_names_and_tags(run: Run) -> None:
    assert run("alias", "Desk lamp", "Reading lamp") == (0, "aliases of desk_lamp: Reading lamp\n")
    assert run("alias", "reading lamp", "Corner") == (0, "aliases of desk_lamp: Corner, Reading lamp\n")
    assert run("tag", "add", "corner", "night") == (0, "tags of desk_lamp: night, warm\n")
    assert "desk_lamp" in run("find", "tag=night")[1]
    assert run("find", "tag=nihgt") == (1, "homebot: no device has the tag 'nihgt'; did you mean night?\n")
    assert run("tag", "remove", "corner", "NIGHT") == (0, "tags of desk_lamp: warm\n")
    assert run("alias", "corner", "Corner", "--undo") == (0, "aliases of desk_lamp: Reading lamp\n")
    assert "desk_lamp  Reading lamp\n" in run("show", "Desk lamp")[1]


@pytest.mark.parametrize("name", ["Front door", "Ceiling but dimmed"])
def test_a_device_is_found_by_a_name_that_means_something_else(run: Run, name: str) -> None:
    run("alias", "Desk lamp", name)
    code, found = run("find", name)
    assert (code, "desk_lamp" in found) == (0, True)


def test_no_device_gets_a_name_of_another(run: Run) -> None:
    run("alias", "Desk lamp", "Corner")
    for taken in ("corner", "Desk lamp", "DESK_LAMP"):
        assert "desk_lamp is called that already" in run("alias", "Ceiling", taken)[1]
    run("alias", "Desk lamp", "Corner", "--undo")
    assert run("alias", "Ceiling", "Corner") == (0, "aliases of ceiling: Corner\n")
    assert run("alias", "Ceiling", "Ceiling") == (0, "aliases of ceiling: Ceiling, Corner\n")


def test_rooms_are_listed_with_their_devices(run: Run) -> None:
    run("place", "ceiling", "Hall")
    code, printed = run("places", "list")
    assert code == 0
    assert [line.split() for line in printed.splitlines()] == [
        ["ROOM", "FLOOR", "DOORS", "DEVICES"],
        ["Hall", "Downstairs", "Kitchen", "1"],
        ["Kitchen", "Downstairs", "Hall", "0"],
        ["Study", "1"],
    ]


def test_rooms_are_listed_as_json(run: Run) -> None:
    run("place", "ceiling", "Hall")
    run("place", "Garden lamp", "Terrace")
    code, printed = run("places", "list", "--json")
    assert (code, json.loads(printed)) == (
        0,
        {
            "home": "home425",
            "rooms": [
                {"name": "Hall", "floor": "Downstairs", "doors": ["Kitchen"], "devices": 1, "areas": []},
                {"name": "Kitchen", "floor": "Downstairs", "doors": ["Hall"], "devices": 0, "areas": []},
                {"name": "Study", "floor": "", "doors": [], "devices": 1, "areas": []},
            ],
            "doors": [
                {
                    "name": door_name(("Hall", "Kitchen")),
                    "rooms": ["Hall", "Kitchen"],
                    "x": [],
                    "y": [],
                    "width": 0.8,
                    "contact": "",
                    "lock": "",
                },
            ],
            "positions": {},
            "absent": [{"device": "garden_lamp", "room": "Terrace"}],
        },
    )


EXPORTED = """\
# Rooms and devices of home425, for `homebot places import` or a homebot.toml.

[places.rooms."Hall"]
floor = "Downstairs"
doors = ["Kitchen"]

[places.rooms."Kitchen"]
floor = "Downstairs"

[places.devices."ceiling"]
room = "Hall"
identifiers = ["mac:000000000001"]

[places.devices."desk_lamp"]
tags = ["warm"]
identifiers = ["mac:000000000000"]
"""


def test_places_are_exported_and_imported(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "house.toml"
    run("place", "ceiling", "Hall")
    assert run("places", "export") == (0, EXPORTED)
    assert run("places", "export", str(file)) == (0, f"wrote {file}\n")
    assert run("places", "import", str(file)) == (0, "everything in the file is already known\n")
    run("place", "ceiling", "Kitchen")
    file.write_text(f"{EXPORTED}[places.rooms.Loft]\n")
    assert run("places", "import", str(file)) == (
        0,
        "imported room Loft\n"
        "kept: ceiling stays in Kitchen; the file says Hall\n"
        "use --replace to use the rooms of the file\n",
    )
    assert run("places", "import", str(file), "--replace") == (0, "imported ceiling\n")
    assert "Hall (Downstairs, home425)" in run("show", "ceiling")[1]


def test_an_import_that_moves_a_room_to_another_floor_says_so(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "house.toml"
    file.write_text('[places.rooms.Hall]\nfloor = "Cellar"\n')
    assert run("places", "import", str(file)) == (0, "imported room Hall\n")
    assert run("places", "import", str(file)) == (0, "everything in the file is already known\n")
    assert ["Hall", "Cellar", "Kitchen", "0"] in [line.split() for line in run("places", "list")[1].splitlines()]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[places.rooms.Hall]\nflor = 'x'", "places.rooms.Hall.flor: unknown key; did you mean floor?"),
        ("[places.devices.lamp]\nroom = 7", "places.devices.lamp.room: must be a text in quotes, got 7"),
        ("[home]\nname = 'x'", "home: unknown key; known is places"),
        ("places = 3", "places: must be a table, got 3"),
        ("[places", "is invalid TOML"),
        ("[home]\nname = villa", "is invalid TOML: Invalid value (at line 2, column 8); a text stands in quotes, true"),
    ],
)
def test_an_import_with_a_mistake_changes_nothing_and_names_it(
    run: Run, tmp_path: Path, text: str, problem: str
) -> None:
    file = tmp_path / "house.toml"
    before = run("places", "export")
    file.write_text(f"[places.rooms.Attic]\n\n{text}" if "rooms" in text else text)
    code, printed = run("places", "import", str(file))
    assert code == 1
    assert printed.startswith(f"homebot: {file}: {problem}")
    assert run("places", "export") == before


def test_a_file_comes_from_standard_input_and_has_a_limit(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    for content, expected in (
        (b"\xef\xbb\xbf[places.rooms.Attic]", (0, "imported room Attic\n")),
        (b"\xff", (1, "homebot: - cannot be read: it is not UTF-8 text\n")),
        (b"#" * 800_001, (1, "homebot: - is larger than 800 kB\n")),
    ):
        monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(content)))
        assert run("places", "import", "-") == expected


GEOMETRY = {
    "rooms": {
        "Hall": {"floor": "Downstairs", "polygon": [[0, 0], [4, 0], [4, 5], [0, 5]]},
        "Kitchen": {"floor": "Downstairs", "polygon": [[3.5, 0], [8, 0], [8, 5], [3.5, 5]]},
    },
    "doors": [{"rooms": ["Hall", "Kitchen"], "position": [3.8, 4.5]}],
    "devices": {"mac:000000000007": {"at": "7,1 +-0.5"}},
}


@pytest.fixture
def house(run_with: Callable[..., Run]) -> Run:
    places = read_places(GEOMETRY, "home425", "homebot.toml", "configuration")
    index = DeviceIndex(forget_after=1000.0, owner=OwnerFacts("home425", places, NOW - 60))
    return run_with(partial(index_node, index))


def test_a_device_at_a_position_is_in_the_room_that_is_there(house: Run) -> None:
    for arguments, told in (
        (("Desk lamp", "--at", "6,1"), "desk_lamp is at 6,1 in Kitchen now\n"),
        (("Ceiling", "--at", "20,1,downstairs"), "ceiling is at 20,1,downstairs now; its room is unknown\n"),
        (
            ("Shelf lamp", "--at", "1,1"),
            "there is no device Shelf lamp yet; shelf_lamp will be at 1,1 when it appears\n",
        ),
    ):
        assert house("place", *arguments) == (0, told)
    assert "desk_lamp  6,1,Downstairs ±0.1 m" in house("places", "list")[1]
    shown = house("show", "Desk lamp")[1]
    assert any("6,1,Downstairs ±0.1 m" in line and "by the owner" in line for line in shown.splitlines())
    assert 'at = "6,1,Downstairs ±0.1 m"' in house("places", "export")[1]
    assert house("place", "Desk lamp", "--undo") == (0, "desk_lamp is in Study now\n")


@pytest.mark.parametrize(
    ("position", "problem"),
    [
        ("6", "is not a position; write X,Y"),
        ("nan,1", "is not within 10,000 m"),
        ("6,1,Attic", "there is no floor 'Attic'; floors are Downstairs"),
    ],
)
def test_a_position_that_cannot_be_is_refused(house: Run, position: str, problem: str) -> None:
    code, printed = house("place", "Desk lamp", "--at", position)
    assert code
    assert problem in printed


def test_the_geometry_of_the_house_is_listed_and_exported(house: Run) -> None:
    listed = json.loads(house("places", "list", "--json")[1])
    assert listed["rooms"][0]["areas"] == [{"x": [0, 4, 4, 0], "y": [0, 0, 5, 5], "is_hole": False}]
    assert [(one["rooms"], one["x"], one["y"]) for one in listed["doors"]] == [(["Hall", "Kitchen"], [3.8], [4.5])]
    lines = house("places", "export")[1].splitlines()
    for line in (
        "polygon = [[0.0, 0.0], [4.0, 0.0], [4.0, 5.0], [0.0, 5.0]]",
        "position = [3.8, 4.5]",
        'at = "7,1,Downstairs ±0.5 m"',
    ):
        assert line in lines


def test_rooms_that_overlap_are_a_note_of_the_doctor(house: Run) -> None:
    assert "note on discovery: the rooms Hall and Kitchen overlap by 2.5 m²" in house("doctor")[1]
