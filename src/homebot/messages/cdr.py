"""Messages in CDR, the bytes in which ROS 2 nodes exchange and record them. Pure.

Little-endian, as stated in the header. Each value is aligned to its own size, counted from the end of the header.

Source: OMG DDS Interoperability Wire Protocol 2.5, section 10 (PLAIN_CDR, version 1); ROS 2 design, "Interface
definition using .msg files" and "Legacy interface definition" for the byte of a message without fields; Fast CDR 2,
``Cdr.cpp``, for wide strings.
"""

import math
import struct
from collections.abc import Sequence
from typing import Any

from homebot.messages.definition import FieldDefinition, fields_of
from homebot.messages.message import Message
from homebot.messages.numeric_array import LAYOUTS, NumericArray

__all__ = ["message_to_cdr"]

_HEADER = b"\x00\x01\x00\x00"  # CDR_LE, no options
_WITHOUT_FIELDS = b"\x00"  # IDL has no empty structures, so ROS 2 gives them a member `uint8`
_LAYOUTS = LAYOUTS | {"bool": "?"}


def message_to_cdr(message: Message) -> bytes:
    """Return *message* in CDR; a number too large for its ``float32`` becomes infinite."""
    out = bytearray(_HEADER)
    _write_message(out, message)
    return bytes(out)


def _write_message(out: bytearray, message: Message) -> None:
    fields = fields_of(type(message))
    if not fields:
        out += _WITHOUT_FIELDS
    for field in fields:
        value = getattr(message, field.name)
        if not field.is_array:
            _write_elements(out, field, (value,))
            continue
        if field.size is None:
            _write_numbers(out, "I", (len(value),))
        if field.is_bytes:
            out += value
        else:
            _write_elements(out, field, value)


def _write_elements(out: bytearray, field: FieldDefinition, values: Sequence[object]) -> None:
    if (layout := _LAYOUTS.get(field.ros_type)) is not None:
        _write_numbers(out, layout, values)
        return
    for value in values:
        if isinstance(value, Message):
            _write_message(out, value)
        elif field.ros_type == "wstring":
            text = str(value).encode("utf-16-le", errors="replace")
            _write_numbers(out, "I", (len(text) // 2,))
            out += text
        else:
            text = str(value).encode(errors="replace") + b"\x00"
            _write_numbers(out, "I", (len(text),))
            out += text


def _write_numbers(out: bytearray, layout: str, values: Sequence[Any]) -> None:
    if not values:
        return
    out += bytes(-(len(out) - len(_HEADER)) % struct.calcsize(f"<{layout}"))
    if isinstance(values, NumericArray):
        out += values.to_bytes(layout)
        return
    try:
        out += struct.pack(f"<{len(values)}{layout}", *values)
    except OverflowError:  # only for float32; integers are validated when the message is created
        out += struct.pack(f"<{len(values)}{layout}", *map(_within_float32, values))


def _within_float32(value: float) -> float:
    try:
        struct.pack("<f", value)
    except OverflowError:
        return math.copysign(math.inf, value)
    return value
