"""Fields, type hashes and bytes of ROS's interfaces, against two packages of other people.

rosbags has the messages of ROS 2 Jazzy, and a codec; ros2_pyterfaces has messages and services, checked against ROS.
"""

import itertools
from collections.abc import Iterator
from functools import cache
from random import Random
from typing import Any

import pytest
from tests.sizes import size

from homebot.devices.access_messages import DefineType
from homebot.messages.action import ActionType
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.definition import FieldDefinition, definition_text, fields_of
from homebot.messages.interfaces import Interfaces, find_action, find_message, find_service, interface_names
from homebot.messages.json import message_from_json, message_to_json
from homebot.messages.message import Message, ServiceType
from homebot.messages.numeric_array import LAYOUTS
from homebot.messages.type_hash import type_hash

rosbags: Any = pytest.importorskip("rosbags.typesys")
pyterfaces: Any = pytest.importorskip("ros2_pyterfaces.core")
numpy: Any = pytest.importorskip("numpy")

JAZZY = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)

WITH_CHAR = {"service_msgs/msg/ServiceEventInfo", "std_msgs/msg/Char"}
"""rosbags 0.11.9 hashes the type of IDL of that name; ROS makes ``uint8`` of it, and so does the other package."""

LATER = {"sensor_msgs/msg/Range"}
"""ros2_pyterfaces 0.3.0 has the fields of another distribution."""

OF_ROSIDL = {
    "action_msgs/srv/CancelGoal": "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    "rmf_door_msgs/msg/DoorRequest": "3145b5d97064f89b0a0db953b8167ddeeefbc2914c24a603c3bdc51f122f143e",
    "rmf_door_msgs/msg/DoorState": "1cb9d98f19c66cbc1f9acb16faaa90c63a7b65021bd26c69958d96f0a0388bb2",
    "rmf_lift_msgs/msg/LiftRequest": "e8f1e0aa4d172703d0d7840c1876448c6c5d75ab58955faf7de7dddc17c096ac",
    "rmf_lift_msgs/msg/LiftState": "ce0553cd08eeeb321bdae554efdb6d2ebb2be9755df2e34895cbef55b51f4c06",
    "tf2_msgs/srv/FrameGraph": "0d1fbc6222c018ba5f33822904a2fdd4063705289956d3fdde07cd8c50fe8067",
    "vision_msgs/msg/Classification": "f74db28d0eaef3afb78f48bf2161cd709a1383a0309d3454383b25be11345143",
    "vision_msgs/msg/Detection2DArray": "214274120007f4a683866481336b70310268cfa107aebe9d594a6acf75bda968",
    "vision_msgs/msg/Detection3DArray": "793f5eab9595ac1c0da07873cc859db42eae51f0ee76056db8562515d830e018",
    "vision_msgs/msg/LabelInfo": "3d37df4015cdf660cc851c51897f2acd957e1ca6205ba0a99aebffb9406b0783",
    "vision_msgs/msg/VisionInfo": "95d3116a17484ad91c9a2686e1d54890bbfc3ff6c6a2de137738c4950d45d284",
}
"""Of types that neither package has: what the code says that ROS 2 generates of them, and of those inside."""

NAMES = interface_names()
SEEDS = range(size(25, 3_400))
"""Each makes three types."""


def find(name: str) -> Any:
    return {"msg": find_message, "srv": find_service, "action": find_action}[name.split("/")[1]](name)


@cache
def schemas() -> dict[str, Any]:
    packages = (pyterfaces.all_msgs, pyterfaces.all_srvs)
    values = (value for package in packages for value in vars(package).values())
    return {value["__typename"]: value for value in values if isinstance(value, dict) and "__typename" in value}


@cache
def messages() -> dict[str, type[Message]]:
    """Return every shipped message, those of services and actions too."""
    found: dict[str, type[Message]] = {}
    for interface in map(find, NAMES):
        match interface:
            case ServiceType():
                parts: tuple[type[Message], ...] = (interface.Request, interface.Response)
            case ActionType():
                parts = (interface.Goal, interface.Result, interface.Feedback, interface.FeedbackMessage)
            case _:
                parts = (interface,)
        found |= {part.ros_type: part for part in parts}
    return found


@pytest.mark.parametrize("name", sorted({*NAMES} & {*JAZZY.fielddefs} - WITH_CHAR))
def test_a_message_is_that_of_rosbags(name: str) -> None:
    assert type_hash(find(name)) == JAZZY.hash_rihs01(name)


def test_messages_and_services_are_those_of_ros2_pyterfaces() -> None:
    compared = ({*NAMES} & {*schemas()}) - LATER
    assert len(compared) > 150
    different = [
        name for name in compared if type_hash(find(name)) != pyterfaces.description.hash_rihs01(schemas()[name])
    ]
    assert different == []


@pytest.mark.parametrize("name", OF_ROSIDL)
def test_a_type_of_further_packages_has_the_hash_that_ros_generates(name: str) -> None:
    assert type_hash(find(name)) == f"RIHS01_{OF_ROSIDL[name]}"


def test_every_shipped_message_is_compared_but_those_of_packages_that_others_do_not_have() -> None:
    """Those of three are compared with the code that ROS generates; the bytes of all are compared below."""
    missing = {name.partition("/")[0] for name in NAMES if name not in JAZZY.fielddefs and name not in schemas()}
    assert {name for name in missing if any(f"{name}/msg/" in one for one in NAMES)} <= {
        "action_msgs",  # a service
        "geographic_msgs",  # as nav2_msgs in neither package: their bytes alone
        "nav2_msgs",
        "rmf_door_msgs",
        "rmf_lift_msgs",
        "tf2_msgs",  # a service and an action
        "vision_msgs",
    }


def test_a_service_of_ours_is_described_by_the_names_of_ros() -> None:
    """The request is a class with a name of its own."""
    texts = "string type\nstring definition\nstring issuer\n---\nbool success\nstring message\nstring type_hash\n"
    assert type_hash(Interfaces().define("homebot/srv/DefineType", texts)) == type_hash(DefineType)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_text_of_a_type_has_the_hash_and_the_bytes_of_rosbags(name: str) -> None:
    for ros_type, message in messages().items():
        if ros_type == name or ros_type.startswith(f"{name}_"):
            compare(message, Random(ros_type))  # noqa: S311 - the same cases each time


@pytest.mark.slow
@pytest.mark.parametrize("start", SEEDS[::100])
def test_random_types_have_the_hash_and_the_bytes_of_rosbags(start: int) -> None:
    for seed in SEEDS[start : start + 100]:
        random = Random(seed)  # noqa: S311 - as above
        interfaces = Interfaces()
        for index in range(3):
            interfaces.define(f"chance_msgs/msg/Type{index}", random_text(random, index))
            compare(interfaces.find_message(f"chance_msgs/Type{index}"), random)


def test_an_action_has_a_hash_of_its_own() -> None:
    """No other package has those of actions."""
    hashes = {type_hash(find(name)) for name in NAMES if "/action/" in name}
    assert len(hashes) == sum("/action/" in name for name in NAMES)
    several = [Interfaces(distribution=one) for one in ("humble", "jazzy", "kilted")]
    assert len({type_hash(one.find_action("nav2_msgs/action/Spin")) for one in several}) == 3


def compare(message_type: type[Message], random: Random) -> None:
    message = random_message(message_type, random)
    store = rosbags.get_typestore(rosbags.Stores.EMPTY)
    name = as_message(message_type.ros_type)
    store.register(rosbags.get_types_from_msg(definition_text(message_type), name))
    if name == message_type.ros_type and not any("char" in field.ros_type for field in every_field(message_type)):
        assert type_hash(message_type) == store.hash_rihs01(name)
    theirs = bytes(store.serialize_cdr(foreign(store, message), name))
    assert message_to_cdr(message) == theirs
    assert message_to_cdr(message_from_cdr(message_type, theirs)) == theirs
    assert message_from_json(message_type, message_to_json(message)) == message


def as_message(ros_type: str) -> str:
    return ros_type.replace("/srv/", "/msg/").replace("/action/", "/msg/")


def every_field(message_type: type[Message]) -> Iterator[FieldDefinition]:
    for field in fields_of(message_type):
        yield field
        if field.message is not None:
            yield from every_field(field.message)


def foreign(store: Any, message: Message) -> Any:
    values = {
        field.name: foreign_value(store, field, getattr(message, field.name)) for field in fields_of(type(message))
    }
    made = store.types[as_message(message.ros_type)]
    return made(**values) if values else made()


def foreign_value(store: Any, field: FieldDefinition, value: Any) -> Any:
    if field.message is not None:
        return [foreign(store, one) for one in value] if field.is_array else foreign(store, value)
    if not field.is_array:
        return value - 256 if field.ros_type == "byte" and value > 127 else value  # it takes them with a sign
    if field.ros_type == "string":
        return list(value)
    return numpy.array(list(value), dtype=numpy.dtype("?" if field.ros_type == "bool" else LAYOUTS[field.ros_type]))


def random_message(message_type: type[Message], random: Random) -> Message:
    return message_type(**{field.name: random_value(field, random) for field in fields_of(message_type)})


def random_value(field: FieldDefinition, random: Random) -> Any:
    if not field.is_array:
        return random_element(field, random)
    bound = 3 if field.bound is None else min(field.bound, 3)
    count = field.size if field.size is not None else random.randint(0, bound)
    values = [random_element(field, random) for _ in range(count)]
    return bytes(values) if field.is_bytes else tuple(values)


def random_element(field: FieldDefinition, random: Random) -> Any:
    if field.message is not None:
        return random_message(field.message, random)
    match field.ros_type:
        case "string":
            return "".join(random.choices('aü客\n"', k=random.randint(0, min(field.longest or 9, 9))))
        case "bool":
            return random.random() < 0.5
        case "float32" | "float64":
            return random.choice((0.0, -1.5, 2.0**-10, 1e6, float(random.randint(-1000, 1000))))
    size = 8 * numpy.dtype(LAYOUTS[field.ros_type]).itemsize
    least = -(2 ** (size - 1)) if field.ros_type.startswith("int") else 0
    return random.choice((least, least + 2**size - 1, random.randint(least, least + 2**size - 1)))


def random_text(random: Random, index: int) -> str:
    """Return the text of a type with random fields, of primitives and of the types before it."""
    primitives = [*LAYOUTS.keys() - {"char"}, "bool", "string"]
    nested = ["std_msgs/Header", "geometry_msgs/Point", "std_msgs/Empty", *(f"Type{one}" for one in range(index))]
    lines = []
    for number in range(random.randint(0, 8)):
        base = random.choice(random.choice((primitives, primitives, nested)))
        if base == "string" and random.random() < 0.3:
            base = f"string<={random.randint(1, 30)}"
        count = random.randint(1, 4)
        lines.append(f"{base}{random.choice(('', '', '[]', f'[{count}]', f'[<={count}]'))} field_{number}  # comment")
    return "\n".join(itertools.chain(["uint8 LIMIT=3", ""], lines))
