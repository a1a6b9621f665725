"""The messages of ROS 2's packages, against what rosbags 0.11.9 says of ROS 2 Jazzy and writes in CDR."""

import itertools
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from homebot.errors import UnknownTypeError
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.definition import FieldDefinition, definition_text, fields_of
from homebot.messages.geometry_msgs import Pose, Quaternion, TwistStamped
from homebot.messages.interfaces import find_message, find_service, interface_names
from homebot.messages.json import message_from_json, message_to_json
from homebot.messages.message import Message

GOLDEN = Path(__file__).parent / "ros_packages.txt"
"""Of each type its name, its fields, and the bytes of the message that :func:`sample` makes."""


def golden() -> Iterator[tuple[str, list[str], bytes]]:
    for block in GOLDEN.read_text().split("\n\n"):
        name, *fields, raw = block.splitlines()
        yield name, fields, bytes.fromhex(raw)


def sample(message_type: type[Message]) -> Message:
    """Return a message whose values count up; of arrays there are two elements."""
    return _sample(message_type, itertools.count(1))


def _sample(message_type: type[Message], numbers: Iterator[int]) -> Message:
    return message_type(**{field.name: _value(field, numbers) for field in fields_of(message_type)})


def _value(field: FieldDefinition, numbers: Iterator[int]) -> object:
    if not field.is_array:
        return _element(field, numbers)
    elements = [_element(field, numbers) for _ in range(field.size or 2)]
    return bytes(elements) if field.is_bytes else tuple(elements)  # type: ignore[arg-type]  # numbers then


def _element(field: FieldDefinition, numbers: Iterator[int]) -> object:
    if field.message is not None:
        return _sample(field.message, numbers)
    number = next(numbers)
    if field.ros_type == "string":
        return f"s{number}"
    if field.ros_type == "bool":
        return number % 2 == 1
    return number / 2 if field.ros_type.startswith("float") else number % 100


@pytest.mark.parametrize(("name", "fields", "raw"), [pytest.param(*one, id=one[0]) for one in golden()])
def test_a_type_has_the_fields_and_the_bytes_of_ros_2(name: str, fields: list[str], raw: bytes) -> None:
    message = sample(find_message(name))
    assert [field.declaration for field in fields_of(find_message(name))] == fields
    assert message_to_cdr(message) == raw
    assert message_from_cdr(find_message(name), raw) == message
    assert message_from_json(find_message(name), message_to_json(message)) == message


def test_the_text_of_a_type_has_those_inside_after_it() -> None:
    titles = [line for line in definition_text(TwistStamped).splitlines() if line.startswith("MSG: ")]
    assert titles == [
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
        "MSG: geometry_msgs/Twist",
        "MSG: geometry_msgs/Vector3",
    ]


def test_a_rotation_without_values_is_none() -> None:
    """The one default that ROS declares in these packages."""
    assert Quaternion() == Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
    there = message_from_json(Pose, {"position": {"x": 1, "y": 2, "z": 3}, "orientation": {}})
    assert isinstance(there, Pose)
    assert there.orientation.w == 1.0


@pytest.mark.parametrize("name", [name for name in interface_names() if "/srv/" in name])
def test_a_service_is_of_its_package(name: str) -> None:
    service = find_service(name)
    assert service.ros_type == name
    assert service.Request.ros_type == f"{name}_Request"
    assert service.Response.ros_type.startswith(f"{name.partition('/')[0]}/srv/")


@pytest.mark.parametrize("name", ["cdr/Message", "../graph/Node", "std_msgs.Bool/Bool", "std_msgs/../Bool", "Bool"])
def test_no_other_module_or_file_is_loaded_for_a_name(name: str) -> None:
    with pytest.raises(UnknownTypeError):
        find_message(name)


@pytest.mark.parametrize(
    "package", ["diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs", "sensor_msgs", "std_msgs"]
)
def test_a_message_is_imported_from_the_module_of_its_package(package: str) -> None:
    module = import_module(f"homebot.messages.{package}")
    names = [name for name in interface_names(package) if "/msg/" in name]
    assert names
    for name in names:
        assert getattr(module, name.rpartition("/")[2]) is find_message(name)
    with pytest.raises(AttributeError, match="Imagee"):
        module.Imagee  # noqa: B018 - asked for
