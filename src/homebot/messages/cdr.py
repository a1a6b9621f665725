"""Messages in CDR, the bytes in which ROS 2 nodes exchange and record them. Pure.

Little-endian, as stated in the header. Each value is aligned to its own size, counted from the end of the header.
Readers of a message believe no length: each is compared with what is left of the bytes.

Source: OMG DDS Interoperability Wire Protocol 2.5, section 10 (PLAIN_CDR, version 1); ROS 2 design, "Interface
definition using .msg files" and "Legacy interface definition" for the byte of a message without fields; Fast CDR 2,
``Cdr.cpp``, for wide strings.
"""

import math
import struct
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Final, TypeAlias, TypeVar

from pydantic import ValidationError

from homebot.errors import TypeMismatchError
from homebot.messages.definition import FieldDefinition, fields_of
from homebot.messages.json import validation_problem
from homebot.messages.message import Message
from homebot.messages.numeric_array import LAYOUTS, NumericArray

MessageT = TypeVar("MessageT", bound=Message)

_Write: TypeAlias = Callable[[bytearray, Any], None]

_HEADER = b"\x00\x01\x00\x00"  # CDR_LE, no options
_WITHOUT_FIELDS = b"\x00"  # IDL has no empty structures, so ROS 2 gives them a member `uint8`
_LAYOUTS = LAYOUTS | {"bool": "?"}
_SIZES = {layout: struct.calcsize(f"<{layout}") for layout in _LAYOUTS.values()}
_PADDED = 3  # DDS fills the end of a message up to four bytes


def message_to_cdr(message: Message) -> bytes:
    """Return *message* in CDR; a number too large for its ``float32`` becomes infinite."""
    out = bytearray()
    _write_message(out, message)
    return _HEADER + out


def _write_message(out: bytearray, message: Message) -> None:
    for name, write in _writers_of(type(message)):
        write(out, getattr(message, name))


@lru_cache(maxsize=1024)
def _writers_of(message_type: type[Message]) -> tuple[tuple[str, _Write], ...]:
    """Return what writes the value of each attribute of *message_type*."""
    writers = tuple((field.name, _writer_of(field)) for field in fields_of(message_type))
    return writers or (("__class__", lambda out, _: out.extend(_WITHOUT_FIELDS)),)


def _writer_of(field: FieldDefinition) -> _Write:
    layout = _LAYOUTS.get(field.ros_type)
    write = _TEXTS.get(field.ros_type, _write_message) if layout is None else _number_writer(layout)
    if not field.is_array:
        return write

    def write_array(out: bytearray, values: Any) -> None:
        if field.size is None:
            _write_length(out, len(values))
        if field.is_bytes:
            out += values
        elif layout is not None:
            _write_numbers(out, layout, values)
        else:
            for value in values:
                write(out, value)

    return write_array


def _number_writer(layout: str) -> _Write:
    size, pack = _SIZES[layout], struct.Struct(f"<{layout}").pack

    def write(out: bytearray, value: Any) -> None:
        if rest := len(out) % size:
            out += bytes(size - rest)
        try:
            out += pack(value)
        except OverflowError:  # only for float32; integers are validated when the message is created
            out += pack(_within_float32(value))

    return write


_write_length: Final = _number_writer("I")


def _write_text(out: bytearray, value: object) -> None:
    text = str(value).encode(errors="replace")
    _write_length(out, len(text) + 1)
    out += text
    out.append(0)


def _write_wide_text(out: bytearray, value: object) -> None:
    text = str(value).encode("utf-16-le", errors="replace")
    _write_length(out, len(text) // 2)
    out += text


_TEXTS: Final[Mapping[str, _Write]] = {"string": _write_text, "wstring": _write_wide_text}


def _write_numbers(out: bytearray, layout: str, values: Sequence[Any]) -> None:
    if not values:
        return
    out += bytes(-len(out) % _SIZES[layout])
    if isinstance(values, NumericArray):
        out += values.to_bytes(layout)
        return
    try:
        out += struct.pack(f"<{len(values)}{layout}", *values)
    except OverflowError:  # as above
        out += struct.pack(f"<{len(values)}{layout}", *map(_within_float32, values))


def _within_float32(value: float) -> float:
    try:
        struct.pack("<f", value)
    except OverflowError:
        return math.copysign(math.inf, value)
    return value


def message_from_cdr(message_type: type[MessageT], data: bytes) -> MessageT:
    """Return the message that *data* is in CDR.

    Raises:
        TypeMismatchError: It is cut off, is of another type or byte order, or a value is not allowed; the message names
        the field, and its value unless it is a secret (``Field(repr=False)``).
    """
    secrets = frozenset(name for name, field in message_type.model_fields.items() if not field.repr)
    try:
        return message_type.model_validate(_CdrReader(data).whole(message_type))
    except _UnreadableError as exc:
        raise TypeMismatchError(f"not a {message_type.ros_type} in CDR: {exc.shown(secrets)}") from None
    except ValidationError as exc:
        problem = validation_problem(exc, secrets)
        raise TypeMismatchError(f"not a {message_type.ros_type} in CDR: {problem}") from None


class _UnreadableError(Exception):
    """A problem with a value of a field, whose path grows on the way out of nested messages."""

    def __init__(self, problem: str, value: object = None) -> None:
        super().__init__(problem)
        self.problem = problem
        self.value = value
        self.path: list[str] = []

    def shown(self, secrets: frozenset[str]) -> str:
        names = self.path[::-1]
        place = f"field {'.'.join(names)!r}: " if names else ""
        is_shown = self.value is not None and not secrets.intersection(names[:1])
        return f"{place}{self.problem}{f', got {self.value!r}' if is_shown else ''}"


class _CdrReader:
    """Reads one message from its start to its end."""

    def __init__(self, data: bytes) -> None:
        if data[:2] != _HEADER[:2]:
            raise _UnreadableError("it begins with 00 01 (little-endian)", data[:2].hex(" "))
        self._data = data
        self._at = len(_HEADER)

    def whole(self, message_type: type[Message]) -> dict[str, object]:
        fields = self._message(message_type)
        if (left := len(self._data) - self._at) > _PADDED:
            raise _UnreadableError(f"{left} bytes are left over: the sender has another version of the type")
        return fields

    def _message(self, message_type: type[Message]) -> dict[str, object]:
        values: dict[str, object] = {}
        fields = fields_of(message_type)
        if not fields:
            self._read_bytes(len(_WITHOUT_FIELDS))
        for field in fields:
            try:
                values[field.name] = self._value(field)
            except _UnreadableError as exc:
                exc.path.append(field.name)
                raise
        return values

    def _value(self, field: FieldDefinition) -> object:
        if not field.is_array:
            return self._elements(field, 1)[0] if field.ros_type in _LAYOUTS else self._element(field)
        count = self._count() if field.size is None else field.size
        if field.bound is not None and count > field.bound:
            raise _UnreadableError(f"at most {field.bound} elements are allowed", count)
        if field.is_bytes:
            return self._read_bytes(count)
        if field.is_numeric:  # is made from little-endian bytes
            return self._numbers(LAYOUTS[field.ros_type], count)
        return self._elements(field, count)

    def _elements(self, field: FieldDefinition, count: int) -> tuple[Any, ...]:
        if not count:
            return ()
        if (layout := _LAYOUTS.get(field.ros_type)) is not None:
            packed = self._numbers(layout, count)
            if layout == "?" and (wrong := packed.strip(b"\x00\x01")):
                raise _UnreadableError("a bool is 0 or 1", wrong[0])
            return struct.unpack(f"<{count}{layout}", packed)
        if count > len(self._data) - self._at:  # the shortest element has a byte
            raise self._cut_off(count)
        return tuple([self._element(field) for _ in range(count)])

    def _element(self, field: FieldDefinition) -> object:
        return self._text(field) if field.message is None else self._message(field.message)

    def _text(self, field: FieldDefinition) -> str:
        is_wide = field.ros_type == "wstring"
        packed = self._read_bytes(self._count() * (2 if is_wide else 1))
        try:
            text = packed.decode("utf-16-le") if is_wide else packed.removesuffix(b"\x00").decode()
        except UnicodeDecodeError as exc:
            place = f"byte {exc.start} is not {exc.encoding}"
            raise _UnreadableError(place, packed[exc.start : exc.start + 4].hex(" ")) from None
        return text if field.choices is None or text not in tuple(field.choices) else field.choices(text)

    def _count(self) -> int:
        self._at += -self._at % 4  # the header has four bytes too
        return int.from_bytes(self._read_bytes(4), "little")

    def _numbers(self, layout: str, count: int) -> bytes:
        if not count:
            return b""
        size = _SIZES[layout]
        padding = -(self._at - len(_HEADER)) % size
        return self._read_bytes(padding + count * size)[padding:]

    def _read_bytes(self, size: int) -> bytes:
        start, self._at = self._at, self._at + size
        if self._at > len(self._data):
            self._at = start
            raise self._cut_off(size)
        return self._data[start : self._at]

    def _cut_off(self, size: int) -> _UnreadableError:
        left = max(len(self._data) - self._at, 0)
        return _UnreadableError(f"it is cut off: {left} of {size} bytes are left")
