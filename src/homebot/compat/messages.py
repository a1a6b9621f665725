"""Messages in the style of rclpy: created empty, with settable fields, and arrays as lists.

Each class corresponds to a message type of homebot; values are validated when a message is sent.
"""

from dataclasses import field, make_dataclass
from functools import lru_cache, partial
from types import SimpleNamespace
from typing import Any, ClassVar

from homebot.messages.cdr import message_to_cdr
from homebot.messages.definition import zero_message
from homebot.messages.interfaces.interface_text import Interface
from homebot.messages.json import message_from_json
from homebot.messages.message import Message, ServiceType
from homebot.messages.numeric_array import NumericArray


class MutableMessage:
    """A message with settable fields; omitted fields have ROS's defaults: 0, False, empty."""

    __slots__: ClassVar[tuple[str, ...]] = ()


@lru_cache(maxsize=1024)
def program_type(interface: Interface) -> Any:
    """Return *interface* for import by programs: a class of mutable messages, or a namespace of such classes."""
    if not isinstance(interface, type):
        names = ("Request", "Response") if isinstance(interface, ServiceType) else ("Goal", "Result", "Feedback")
        parts = {name: program_type(getattr(interface, name)) for name in names}
        return SimpleNamespace(_interface=interface, **parts)
    zero = zero_message(interface)
    fields = [
        (name, object, field(default_factory=partial(to_program, getattr(zero, name))))
        for name in interface.model_fields
    ]
    body = {name: value for name, value in vars(interface).items() if name.isupper()}  # the constants
    body |= {"_interface": interface, "__doc__": interface.__doc__}
    return make_dataclass(interface.__name__, fields, bases=(MutableMessage,), namespace=body, kw_only=True, slots=True)


def to_program(value: object) -> Any:
    """Return *value*, with messages converted to mutable ones, and arrays to lists."""
    if isinstance(value, Message):
        fields = {name: to_program(getattr(value, name)) for name in type(value).model_fields}
        return program_type(type(value))(**fields)
    if isinstance(value, NumericArray):
        return value.tolist()
    return [to_program(item) for item in value] if isinstance(value, tuple) else value


def to_graph(value: Any) -> Any:
    """Return *value*, with a program's messages and types converted to homebot's."""
    interface = getattr(value, "_interface", value)
    return message_from_json(interface, _plain(value)) if isinstance(value, MutableMessage) else interface


def serialize_message(message: Any) -> bytes:
    """Return *message* in CDR, as it is on the wire of ROS 2."""
    return message_to_cdr(to_graph(message))


def _plain(value: Any) -> Any:
    if isinstance(value, MutableMessage):
        return {name: _plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bytearray):
        return bytes(value)
    return value.tolist() if hasattr(value, "tolist") else value  # the module array, and numpy
