"""Interfaces by name: of the text of their files, of folders, and of clients."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from homebot.bridges.rosbridge.types import own_modules
from homebot.errors import UnknownTypeError, UsageError
from homebot.messages import Message, Time
from homebot.messages.cdr import message_to_cdr
from homebot.messages.definition import definition_text, fields_of
from homebot.messages.interfaces import Interfaces, find_action, find_message, find_service, interfaces
from homebot.messages.interfaces.interface_text import parse_interface
from homebot.messages.std_msgs import Header
from homebot.messages.type_hash import type_hash

DISTRIBUTIONS = ("humble", "jazzy", "kilted")
SHARE = Path(interfaces.__file__).parents[1] / "share"

PET = """\
# A pet.
uint8 CAT=1   # the usual one
string MOTTO="a # b"
int32 HIDDEN=-0x10

std_msgs/Header header
string<=5 name "rex"
uint8[4] tag [1, 2, 3, 4]
float32[<=3] weights
Toy[] toys      # may be none
bool is_tame true
================================================================================
MSG: my_pets/Toy
string[2] colors ["red", 'green, blue']
"""


@pytest.mark.parametrize(
    ("line", "kept"),
    [
        ("string A='a # b' # c", "a # b"),
        ("string A='it\\'s # b' # c", "it's # b"),
        ("string A=it's # b", "it's"),
        ('string A=it\'s "# b" #c', 'it\'s "# b"'),
        ("string A=5' 6\" # b' # c", "5' 6\" # b'"),
    ],
)
def test_a_comment_begins_outside_of_quotation_marks_that_are_closed(line: str, kept: str) -> None:
    (message,) = parse_interface("my_pets/msg/Toy", line)
    assert message.constants == {"A": kept}


def test_the_shipped_names_are_those_of_the_files_and_the_classes() -> None:
    names = {f"{path.parent.parent.name}/{path.parent.name}/{path.stem}" for path in SHARE.rglob("*.*")}
    for module in interfaces._CLASSES.values():
        names |= interfaces._classes_in((module,)).keys()
    assert (SHARE / "names").read_text().split() == sorted(names)


def test_a_type_has_one_class_which_is_that_of_its_module() -> None:
    assert find_message("std_msgs/msg/Header") is find_message("std_msgs/Header") is Header
    assert find_service("nav_msgs/GetMap") is find_service("nav_msgs/srv/GetMap")
    action = find_action("nav2_msgs/action/NavigateToPose")
    assert action.Goal.ros_type == "nav2_msgs/action/NavigateToPose_Goal"
    assert action.FeedbackMessage is find_action("nav2_msgs/NavigateToPose").FeedbackMessage


def test_a_shipped_type_is_one_class_for_all_of_a_process() -> None:
    """A topic refuses another class of the same name: an app and a client could not meet on it."""
    others = (Interfaces(), Interfaces({"my_pets/msg/Toy": ""}), Interfaces(distribution="kilted"))
    for name in ("rmf_door_msgs/msg/DoorState", "visualization_msgs/msg/Marker"):
        assert {find_message(name), *(one.find_message(name) for one in others)} == {find_message(name)}
    assert others[0].find_action("nav2_msgs/Spin") is find_action("nav2_msgs/Spin")
    assert others[2].find_action("nav2_msgs/DockRobot") is find_action("nav2_msgs/DockRobot")
    assert others[1].find_message("my_pets/Toy").model_fields == {}


def test_a_definition_has_constants_defaults_bounds_and_nested_types() -> None:
    pet = Interfaces().define("my_pets/msg/Pet", PET)
    assert isinstance(pet, type)
    assert [field.declaration for field in fields_of(pet)] == [
        "std_msgs/Header header",
        "string<=5 name",
        "uint8[4] tag",
        "float32[<=3] weights",
        "my_pets/Toy[] toys",
        "bool is_tame",
    ]
    header = Header(stamp=Time(sec=0, nanosec=0), frame_id="")
    made = pet.model_validate({"header": header, "weights": [1.5], "toys": ()})
    shown = {name: getattr(made, name) for name in ("CAT", "MOTTO", "HIDDEN", "name", "tag", "weights", "is_tame")}
    assert shown == {
        "CAT": 1,
        "MOTTO": "a # b",
        "HIDDEN": -16,
        "name": "rex",
        "tag": b"\x01\x02\x03\x04",
        "weights": (1.5,),
        "is_tame": True,
    }
    for wrong in ({"name": "longer"}, {"tag": b"123"}, {"weights": [1.0] * 4}):
        with pytest.raises(ValidationError):
            pet.model_validate({"header": header, "weights": [], "toys": ()} | wrong)


def test_integers_may_begin_with_zeros_and_strings_be_wide() -> None:
    """As the packages of ROS write them; a wide string is counted and written in units of UTF-16."""
    wide = Interfaces().define("my_pkg/msg/Wide", "wstring data\nwstring<=3[] more\nint8 first 010\nint8 SECOND=0b11\n")
    assert isinstance(wide, type)
    assert [field.declaration for field in fields_of(wide)] == ["wstring data", "wstring<=3[] more", "int8 first"]
    made = wide.model_validate({"data": "é😀", "more": ("abc",)})
    assert (made.model_dump()["first"], vars(wide)["SECOND"]) == (10, 3)
    assert message_to_cdr(made)[4:] == bytes.fromhex("03000000 e900 3dd8 00de 0000 01000000 03000000 6100 6200 6300 0a")
    with pytest.raises(ValidationError):
        wide.model_validate({"data": "", "more": ("abcd",)})
    of_ros = Interfaces().define("example_interfaces/msg/WString", "wstring data\n")
    assert type_hash(of_ros) == "RIHS01_32033e06d9dfe5468c5d6e1dc8b7a23c8910bad071cfd4e151a951d580e68dd8"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("int33 a", "line 1: 'int33' is not a type"),
        ("int8 a\nint8 a", "line 2: there are two 'a'"),
        ("int8 A", "line 1: a field has small letters"),
        ("int8 a 200", "line 1: 200 is out of the range of int8"),
        ("uint8 A=-1", "line 1: -1 is out of the range of uint8"),
        ("int8[] A=1", "line 1: a constant is of one primitive"),
        ("int8[2] a [1]", "line 1: there are 1 values"),
        ("bool a maybe", "line 1: a bool is true or false"),
        ("int8[0] a", "line 1: the length of an array is at least 1"),
        ("int8<=3 a", "line 1: only a string has a bound"),
        ("wchar a", "line 1: 'wchar' is not a type"),
        ("int8 a 0x", "line 1: invalid literal"),
        ("Point", "line 1: a line is TYPE NAME"),
        ("Nowhere a", "my_pkg/msg/Mine has a field of an unknown message type 'my_pkg/msg/Nowhere'"),
        ("Mine a", "my_pkg/msg/Mine contains itself"),
        ("string json", "messages have a 'json' of their own"),
        ("int8 a\n---\nint8 b", "a .msg file has 1 parts"),
        ("bool a\n" * 10_000, "at most 65536 are read"),
        ("\n".join(f"bool a{number}" for number in range(301)), "more than 300 fields"),
        ("int8[100001] a", "at most 100000"),
        ("int8 a\n" + "=" * 80 + "\nMSG: std_msgs/Header\nint8 a\n", "std_msgs/msg/Header is known with other fields"),
    ],
)
def test_a_wrong_definition_is_refused_with_its_line_and_nothing_of_it_stays(text: str, problem: str) -> None:
    known = Interfaces()
    before = known.names()
    with pytest.raises(UsageError) as refused:
        known.define("my_pkg/msg/Mine", text)
    assert problem in str(refused.value)
    assert known.names() == before
    with pytest.raises(UnknownTypeError):
        known.find_message("my_pkg/Mine")


def test_nested_types_multiply_to_no_more_than_a_message_may_hold() -> None:
    """Ten of ten of ten …: a client could spell a message that fills the memory in some hundred characters."""
    known = Interfaces()
    known.define("deep/D0", "int8 a")
    for level in range(1, 5):
        known.define(f"deep/D{level}", f"D{level - 1}[10] a")
    with pytest.raises(UsageError, match="at most 100000 in 20 are possible"):
        known.define("deep/D5", "D4[10] a")
    for level in range(1, 20):
        known.define(f"deep/E{level}", f"E{level - 1} a" if level > 1 else "int8 a")
    with pytest.raises(UsageError, match="21 levels"):
        known.define("deep/E21", "E20 a\n" + "=" * 80 + "\nMSG: deep/E20\nE19 a\n")


def test_a_definition_that_comes_again_is_the_same_type_and_another_one_is_refused() -> None:
    known = Interfaces()
    pet = known.define("my_pets/Pet", PET)
    assert isinstance(pet, type)
    assert known.define("my_pets/msg/Pet", definition_text(pet)) is pet
    with pytest.raises(UsageError, match=r"my_pets/msg/Pet is known with other fields \(std_msgs/Header header, "):
        known.define("my_pets/Pet", "int8 a")
    assert known.define("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id") is Header


def test_clients_define_a_bounded_number_of_types() -> None:
    known = Interfaces()
    for number in range(200):
        known.define(f"many/T{number}", "int8 a", "client:one")
    with pytest.raises(UsageError, match="this client has defined 200 types, of 200 at most"):
        known.define("many/More", "int8 a", "client:one")
    known.define("many/T7", "int8 a", "client:one")
    known.define("many/More", "int8 a", "client:other")


@pytest.mark.parametrize("package", ["std_msgs", "builtin_interfaces", "homebot"])
def test_clients_define_no_types_in_packages_of_homebot(package: str) -> None:
    known = Interfaces()
    known.add_modules("homebot", own_modules())
    for name, definition in (
        (f"{package}/Mine", "int8 a"),
        ("my_pets/Pet", f"{package}/Mine a\n{'=' * 80}\nMSG: {package}/Mine\nint8 a"),
    ):
        with pytest.raises(UsageError, match=f"{package}/msg/Mine: the package {package} is not for types of clients"):
            known.define(name, definition)
    with pytest.raises(UnknownTypeError):
        known.find_message(f"{package}/Mine")


def test_services_and_actions_are_defined_too() -> None:
    known = Interfaces()
    known.define("my_pets/srv/Feed", "string name\n---\nbool success\n")
    known.define("my_pets/action/Walk", "float32 minutes\n---\nint32 steps\n---\nint32 steps\n")
    assert list(known.find_service("my_pets/Feed").Request.model_fields) == ["name"]
    assert list(known.find_action("my_pets/Walk").SendGoal.Request.model_fields) == ["goal_id", "goal"]


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_the_actions_of_nav2_are_those_of_the_distribution(distribution: str) -> None:
    spin = Interfaces(distribution=distribution).find_action("nav2_msgs/action/Spin")
    fields = [*spin.Goal.model_fields, *spin.Result.model_fields]
    assert ("disable_collision_checks" in fields) == (distribution == "kilted")
    assert ("error_msg" in fields) == (distribution != "humble")
    assert len({type_hash(Interfaces(distribution=one).find_action(spin.ros_type)) for one in DISTRIBUTIONS}) == 3


def test_a_folder_of_the_owner_is_read_with_its_packages(tmp_path: Path) -> None:
    for path, text in {
        "src/my_pets/msg/Toy.msg": "string color",
        "src/my_pets/srv/Feed.srv": "Toy toy\n---\n",
        "my_robot/action/Fetch.action": "my_pets/Toy toy\n---\n---\n",
        "my_robot/README.md": "none",
    }.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    known = Interfaces(Interfaces.read_folder(tmp_path))
    assert known.names("my_pets") == ("my_pets/msg/Toy", "my_pets/srv/Feed")
    goal: type[Message] = known.find_action("my_robot/Fetch").Goal
    toy = fields_of(goal)[0]
    assert toy.message is known.find_message("my_pets/Toy")
    (tmp_path / "my_robot/action/wrong-name.action").write_text("")
    with pytest.raises(UsageError, match=r"its name in CamelCase"):
        Interfaces.read_folder(tmp_path)
