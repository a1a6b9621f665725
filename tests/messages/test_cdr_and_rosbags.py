"""Random messages of every shipped type in CDR: rosbags and homebot read what the other writes, and nothing cut."""

import struct
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from homebot.bridges.rosbridge.types import own_modules
from homebot.errors import TypeMismatchError
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.definition import FieldDefinition, definition_text, fields_of
from homebot.messages.interfaces import Interfaces, find_action, find_message, find_service, interface_names
from homebot.messages.interfaces.interface_text import messages_in
from homebot.messages.message import Message
from homebot.messages.numeric_array import LAYOUTS, NumericArray

STORE: Any = get_typestore(Stores.ROS2_JAZZY)
LETTERS = "ab \n√§Ω漢😀"
MOST = 3
"""Elements of an array without a bound, and letters of a text."""


def shipped() -> Iterator[type[Message]]:
    """Yield each message, and those of each service and action."""
    for name in interface_names():
        if "/msg/" in name:
            yield find_message(name)
        elif "/srv/" in name:
            yield from messages_in(find_service(name))
        else:
            action = find_action(name)
            yield from messages_in(action)
            yield action.FeedbackMessage
            for service in (action.SendGoal, action.GetResult):
                yield from (service.Request, service.Response)


def own() -> Iterator[type[Message]]:
    """Yield homebot's messages."""
    known = Interfaces()
    known.add_modules("homebot", own_modules())
    for name in known.names("homebot"):
        find: Any = {"msg": known.find_message, "srv": known.find_service, "action": known.find_action}[
            name.split("/")[1]
        ]
        yield from messages_in(find(name))


def random_of(message_type: type[Message]) -> Random:
    return Random(message_type.ros_type)  # noqa: S311 - the same cases each time


def random_message(message_type: type[Message], random: Random) -> Message:
    """Return a message with any values, also those that homebot's own do not allow."""
    values: dict[str, Any] = {field.name: random_value(field, random) for field in fields_of(message_type)}
    return message_type.model_construct(**values)


def random_value(field: FieldDefinition, random: Random) -> object:
    if not field.is_array:
        return random_element(field, random)
    length = field.size if field.size is not None else random.randint(0, min(field.bound or MOST, MOST))
    elements: list[Any] = [random_element(field, random) for _ in range(length)]
    if field.is_numeric:
        return NumericArray(LAYOUTS[field.ros_type], elements)
    return bytes(elements) if field.is_bytes else tuple(elements)


def random_element(field: FieldDefinition, random: Random) -> object:
    if field.message is not None:
        return random_message(field.message, random)
    if field.ros_type in LAYOUTS:
        layout = f"<{LAYOUTS[field.ros_type]}"
        if layout in {"<f", "<d"}:
            return struct.unpack(layout, struct.pack(layout, random.uniform(-1e30, 1e30)))[0]
        return struct.unpack(layout, random.randbytes(struct.calcsize(layout)))[0]
    if field.ros_type == "bool":
        return random.random() < 0.5
    return "".join(random.choices(LETTERS, k=random.randint(0, MOST)))


def name_at_rosbags(message_type: type[Message]) -> str:
    """Return the name of *message_type* at rosbags, which has the messages of ROS 2 itself and none of services."""
    package, _, name = message_type.ros_type.split("/")
    known = f"{package}/msg/{name}"
    if known not in STORE.fielddefs:
        found = get_types_from_msg(definition_text(message_type), known)
        STORE.register({one: fields for one, fields in found.items() if one not in STORE.fielddefs})
    return known


TYPES = [pytest.param(one, id=one.ros_type) for one in shipped()]


OWN_TYPES = [pytest.param(one, id=one.ros_type) for one in dict.fromkeys(own())]


def written_by_rosbags(message: Message) -> bytes:
    """Return what rosbags writes of what it reads."""
    name, raw = name_at_rosbags(type(message)), message_to_cdr(message)
    again = bytes(STORE.serialize_cdr(STORE.deserialize_cdr(raw, name), name))
    assert again == raw
    return again


@pytest.mark.parametrize("message_type", TYPES)
def test_rosbags_and_homebot_read_what_the_other_writes(message_type: type[Message]) -> None:
    random = random_of(message_type)
    for _ in range(10):
        message = random_message(message_type, random)
        assert message_from_cdr(message_type, written_by_rosbags(message)) == message


@pytest.mark.parametrize("message_type", OWN_TYPES)
def test_rosbags_reads_messages_of_homebot(message_type: type[Message]) -> None:
    random = random_of(message_type)
    for _ in range(10):
        written_by_rosbags(random_message(message_type, random))


@pytest.mark.parametrize("message_type", TYPES)
def test_a_random_message_cut_anywhere_is_refused(message_type: type[Message]) -> None:
    random = random_of(message_type)
    raw = message_to_cdr(random_message(message_type, random))
    for size in random.sample(range(len(raw)), min(len(raw), 30)):
        with pytest.raises(TypeMismatchError, match=r"cut off|begins with 00 01"):
            message_from_cdr(message_type, raw[:size])
