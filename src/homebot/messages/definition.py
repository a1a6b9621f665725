"""Definition of a message type in ROS: its fields, and the text of its ``.msg`` file."""

import typing
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from itertools import chain
from typing import Any, Final, Literal, TypeVar, get_args, get_origin

from annotated_types import MaxLen, MinLen
from pydantic.fields import FieldInfo

from homebot.errors import UsageError
from homebot.messages.message import Message, RosType
from homebot.messages.numeric_array import LAYOUTS, NumericArray, RosArray

MessageT = TypeVar("MessageT", bound=Message)

TEXTS: Final = ("string", "wstring")
"""The primitives that are text."""

_ZEROS = {"bool": False, "string": "", "wstring": "", "float32": 0.0, "float64": 0.0}
_PRIMITIVES: dict[object, str] = {bool: "bool", int: "int64", float: "float64", str: "string"}


@dataclass(frozen=True, slots=True)
class FieldDefinition:
    """One field of a message type.

    Attributes:
        ros_type: The ROS type of one element: a primitive such as ``uint8``, or the full name of a message type.
        message: The Python class if the element is a message, else None.
        size: Exact number of elements of a fixed array, else None.
        bound: Largest number of elements of a bounded array, else None.
        choices: The enumeration if the element is a text from one, else None.
        is_numeric: True if the Python value is a :class:`~homebot.messages.numeric_array.NumericArray`.
        longest: Largest number of characters if the element is a bounded text, else None.
    """

    name: str
    ros_type: str
    message: type[Message] | None = None
    is_array: bool = False
    size: int | None = None
    bound: int | None = None
    choices: type[StrEnum] | None = None
    is_numeric: bool = False
    longest: int | None = None

    @property
    def is_bytes(self) -> bool:
        """True if the Python value is ``bytes``, the only form of ``uint8[]``."""
        return self.is_array and self.ros_type == "uint8"

    @property
    def is_base64(self) -> bool:
        """True if the value is base64 text in JSON, and bytes in CBOR: an array of ``uint8`` or ``char``."""
        return self.is_array and self.ros_type in {"uint8", "char"}

    def value_in(self, message: Message) -> Any:
        """Return the value in *message* in the form that is sent; an array of ``char`` as bytes."""
        value = getattr(message, self.name)
        return value.to_bytes("B") if self.is_base64 and isinstance(value, NumericArray) else value

    @property
    def declaration(self) -> str:
        """The field's line in a ``.msg`` file."""
        parts = self.ros_type.split("/")
        short = f"{parts[0]}/{parts[2]}" if len(parts) == 3 else self.ros_type  # package/msg/Name
        if self.longest is not None:
            short = f"{short}<={self.longest}"
        if not self.is_array:
            return f"{short} {self.name}"
        inner = str(self.size) if self.size is not None else f"<={self.bound}" if self.bound is not None else ""
        return f"{short}[{inner}] {self.name}"


@lru_cache(maxsize=1024)
def fields_of(message_type: type[Message]) -> tuple[FieldDefinition, ...]:
    """Return the fields of *message_type* in order."""
    return tuple(_definition(message_type, name, field) for name, field in message_type.model_fields.items())


@lru_cache(maxsize=1024)
def fields_by_name(message_type: type[Message]) -> Mapping[str, FieldDefinition]:
    """Return :func:`fields_of` by name, in order."""
    return {field.name: field for field in fields_of(message_type)}


@lru_cache(maxsize=1024)
def zero_message(message_type: type[MessageT]) -> MessageT:
    """Return the message that ROS creates without arguments: every field has its default, or is zero or empty."""
    known = message_type.model_fields
    fields = {field.name: zero_of(field) for field in fields_of(message_type) if known[field.name].is_required()}
    for name in fields:
        if get_origin(known[name].annotation) is Literal:
            fields[name] = get_args(known[name].annotation)[0]
    return message_type(**fields)


def nested_types(message_type: type[Message]) -> tuple[type[Message], ...]:
    """Return the distinct message types in *message_type*, at any depth, in order of first use."""
    types: dict[type[Message], None] = {}
    for field in fields_of(message_type):
        if field.message is not None:
            types |= dict.fromkeys((field.message, *nested_types(field.message)))
    return tuple(types)


def definition_text(message_type: type[Message]) -> str:
    """Return the text of the ``.msg`` file, followed by the nested types like in ``gendeps --cat`` and rosbag2."""
    sections = [definition_body(message_type)]
    for nested in nested_types(message_type):
        package, _, name = nested.ros_type.split("/")
        sections.append(f"{'=' * 80}\nMSG: {package}/{name}\n{definition_body(nested)}")
    return "".join(sections)


def zero_of(field: FieldDefinition) -> object:
    """Return the zero or empty value of *field*."""
    if field.is_bytes:
        return bytes(field.size or 0)
    if field.is_numeric:
        return NumericArray(LAYOUTS[field.ros_type], (0,) * (field.size or 0))
    zero: object = 0
    if field.message is not None:
        zero = zero_message(field.message)
    elif field.choices is not None:
        zero = next(iter(field.choices))
    elif field.ros_type in _ZEROS:
        zero = _ZEROS[field.ros_type]
    return (zero,) * (field.size or 0) if field.is_array else zero


def definition_body(message_type: type[Message]) -> str:
    """Return the text of the ``.msg`` file without the nested types."""
    return "".join(f"{field.declaration}\n" for field in fields_of(message_type))


def _definition(owner: type[Message], name: str, field: FieldInfo) -> FieldDefinition:
    annotation, metadata = field.annotation, tuple(field.metadata)
    if annotation is bytes:
        return FieldDefinition(name, "uint8", is_array=True, **_bounds(metadata))
    numbers = next((mark for mark in metadata if isinstance(mark, RosArray)), None)
    if numbers is not None:
        return FieldDefinition(name, numbers.name, is_array=True, is_numeric=True, **_bounds(metadata))
    array: dict[str, Any] = {}
    if get_origin(annotation) is tuple and get_args(annotation)[1:] == (Ellipsis,):
        array = {"is_array": True, **_bounds(metadata)}
        annotation, metadata = _of_element(get_args(annotation)[0])
    element, message = _element(owner, name, annotation, metadata)
    if array and element == "uint8":
        raise UsageError(f"{owner.__name__}.{name}: a sequence of uint8 is written bytes")
    choices = annotation if isinstance(annotation, type) and issubclass(annotation, StrEnum) else None
    return FieldDefinition(name, element, message, choices=choices, longest=_longest(metadata), **array)


def _of_element(annotated: Any) -> tuple[Any, tuple[object, ...]]:
    """Return the type and the marks of the elements of an array."""
    if get_origin(annotated) is typing.Annotated:
        annotation, *marks = get_args(annotated)
        return annotation, tuple(marks)
    return annotated, ()


def _is_text(annotation: object) -> bool:
    if get_origin(annotation) is Literal:
        return all(isinstance(value, str) for value in get_args(annotation))
    return isinstance(annotation, type) and issubclass(annotation, str)


def _element(
    owner: type[Message], name: str, annotation: object, metadata: tuple[object, ...]
) -> tuple[str, type[Message] | None]:
    for mark in metadata:
        if isinstance(mark, RosType):
            return mark.name, None
    if annotation in _PRIMITIVES:
        return _PRIMITIVES[annotation], None
    if _is_text(annotation):
        return "string", None
    if isinstance(annotation, type) and issubclass(annotation, Message):
        return annotation.ros_type, annotation
    raise UsageError(f"{owner.__name__}.{name}: {annotation!r} has no ROS type; see homebot.messages.message")


def _longest(metadata: tuple[object, ...]) -> int | None:
    """Return the bound of a text that is declared as a ``RosType`` of text with a maximum length.

    Other maximum lengths of texts are only limits of homebot's messages, not of their ROS types.
    """
    if not any(isinstance(mark, RosType) and mark.name in TEXTS for mark in metadata):
        return None
    flat = chain.from_iterable(mark.metadata if isinstance(mark, FieldInfo) else (mark,) for mark in metadata)
    return next((mark.max_length for mark in flat if isinstance(mark, MaxLen)), None)


def _bounds(metadata: tuple[object, ...]) -> dict[str, Any]:
    shortest = next((mark.min_length for mark in metadata if isinstance(mark, MinLen)), 0)
    longest = next((mark.max_length for mark in metadata if isinstance(mark, MaxLen)), None)
    return {"size" if shortest == longest else "bound": longest}
