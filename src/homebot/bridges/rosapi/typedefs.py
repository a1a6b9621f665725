"""Message types as the ``TypeDef`` of rosapi: plain lists that a client without the types can read."""

from __future__ import annotations

from homebot.messages.definition import FieldDefinition, fields_of, nested_types
from homebot.messages.message import Int32, Message

__all__ = ["TypeDef", "typedefs_of"]


_EXAMPLES = {"bool": "False", "string": "", "wstring": "", "float32": "0.0", "float64": "0.0"}


class TypeDef(Message, ros_type="rosapi_msgs/msg/TypeDef"):
    """The fields of a message type.

    Attributes:
        type: Its name, as ``package/Name``.
        fieldnames: Its fields.
        fieldtypes: The fields' types; of one element where the field is an array.
        fieldarraylen: -1 for one value, 0 for any number of values, else exactly that many.
        examples: A value of each field, as text.
        constnames: Its constants.
        constvalues: Their values, as text.
    """

    type: str
    fieldnames: tuple[str, ...]
    fieldtypes: tuple[str, ...]
    fieldarraylen: tuple[Int32, ...]
    examples: tuple[str, ...]
    constnames: tuple[str, ...]
    constvalues: tuple[str, ...]


def typedefs_of(message_type: type[Message]) -> tuple[TypeDef, ...]:
    """Return *message_type* and, after it, every type in it, each once."""
    return tuple(_typedef(one) for one in (message_type, *nested_types(message_type)))


def _typedef(message_type: type[Message]) -> TypeDef:
    fields = fields_of(message_type)
    constants = {name: str(value) for name, value in vars(message_type).items() if name.isupper()}
    return TypeDef(
        type=_short(message_type.ros_type),
        fieldnames=tuple(field.name for field in fields),
        fieldtypes=tuple(_short(field.ros_type) for field in fields),
        fieldarraylen=tuple(_array_length(field) for field in fields),
        examples=tuple(_example(field) for field in fields),
        constnames=tuple(constants),
        constvalues=tuple(constants.values()),
    )


def _short(ros_type: str) -> str:
    package, slash, rest = ros_type.partition("/")
    return f"{package}{slash}{rest.rpartition('/')[2]}"


def _array_length(field: FieldDefinition) -> int:
    return -1 if not field.is_array else field.size or 0


def _example(field: FieldDefinition) -> str:
    if field.is_array:
        return "[]"
    return "{}" if field.message is not None else _EXAMPLES.get(field.ros_type, "0")
