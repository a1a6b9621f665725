"""Messages as JSON values in the form of rosbridge v2.

Arrays of ``uint8`` and ``char`` are base64 text, NaN and infinity null; null is read as NaN.

Source: RobotWebTools rosbridge_suite, ROSBRIDGE_PROTOCOL.md, section 2.
"""

import base64
import json
import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from typing import Any, TypeAlias, TypeVar

from pydantic import ValidationError
from pydantic_core import PydanticSerializationError, to_json

from homebot.errors import TypeMismatchError
from homebot.messages.definition import FieldDefinition, fields_by_name, fields_of, nested_types
from homebot.messages.message import Message
from homebot.messages.numeric_array import NumericArray
from homebot.support.strict_json import in_ascii

JsonValue: TypeAlias = "bool | int | float | str | list[JsonValue] | dict[str, JsonValue] | None"
JsonObject: TypeAlias = "dict[str, JsonValue]"

MessageT = TypeVar("MessageT", bound=Message)

_REAL = frozenset({"float32", "float64"})

_PIECE, _LONG = 50, 50_000
"""Messages per piece, and the text length from which there are fewer: about a millisecond, two for devices."""


def message_to_json(message: Message, *, finite: bool = True) -> JsonObject:
    """Return *message* as a JSON object with its fields in order.

    Args:
        finite: Whether NaN and infinity are null; else they stay, as Python's ``json`` and homebot's door read them.
    """
    return {field.name: _value_to_json(field.value_in(message), finite=finite) for field in fields_of(type(message))}


def message_to_text(message: Message) -> str:
    """Return :func:`message_to_json` as ASCII text, in a tenth of the time if no field contains bytes."""
    if not _holds_bytes(type(message)):
        with suppress(PydanticSerializationError):  # an unchecked value: written below, or named in the error
            return in_ascii(message.model_dump_json(warnings="error"))
    return json.dumps(message_to_json(message), separators=(",", ":"), allow_nan=False)


def message_to_pieces(message: Message) -> Iterator[str]:
    """Yield the text of *message* in pieces, because thousands of nested messages would block others too long."""
    text = "{"
    for field in fields_of(type(message)):
        value = field.value_in(message)
        text += f'{"" if text == "{" else ","}"{field.name}":'
        if isinstance(value, NumericArray):
            text += to_json(_value_to_json(value)).decode()
            continue
        if field.message is None or not field.is_array:
            text += json.dumps(_value_to_json(value), separators=(",", ":"), allow_nan=False)
            continue
        text += "["
        for number, item in enumerate(value):
            text += f"{',' if number else ''}{message_to_text(item)}"
            if number % _PIECE == _PIECE - 1 or len(text) > _LONG:
                yield text
                text = ""
        text += "]"
    yield f"{text}}}"


def message_from_json(
    message_type: type[MessageT], value: Mapping[str, object], *, ignore_unknown: bool = False
) -> MessageT:
    """Return the message that the JSON object *value* spells.

    Bytes, and the numbers of an array as little-endian bytes, may come as base64 text or as a list.

    Args:
        ignore_unknown: Whether unknown fields, such as those of a newer homebot, are ignored rather than refused.

    Raises:
        TypeMismatchError: A field is missing, unknown, or of another type; the message names the field, and its value
        unless it is a secret (``Field(repr=False)``).
    """
    if not isinstance(value, Mapping):
        raise TypeMismatchError(f"not a {message_type.ros_type}: expected an object, got {_show(value)}")
    try:
        return message_type.model_validate(_fields_from_json(message_type, value))
    except ValidationError as exc:
        if ignore_unknown and any(error["type"] == "extra_forbidden" for error in exc.errors()):
            return message_from_json(message_type, _known_fields(message_type, value))
        secrets = frozenset(name for name, field in message_type.model_fields.items() if not field.repr)
        problem = validation_problem(exc, secrets)
        raise TypeMismatchError(f"not a {message_type.ros_type}: {problem}") from exc


def validation_problem(error: ValidationError, secrets: frozenset[str] = frozenset()) -> str:
    """Return the first problem of *error* in one line: the field's path, the problem and the value.

    The values of the fields *secrets* are not shown.
    """
    all_errors = error.errors(include_url=False)
    first = all_errors[0]
    if first["loc"] and first["loc"][0] in secrets:
        return f"field {first['loc'][0]!r}: {first['msg'][:1].lower()}{first['msg'][1:]}"
    path = ".".join(str(part) for part in first["loc"])
    if first["type"] == "missing":
        unknown = [problem["loc"] for problem in all_errors if problem["type"] == "extra_forbidden"]
        instead = f", and field {'.'.join(map(str, unknown[0]))!r} is unknown" if unknown else ""
        return f"field {path!r} is missing{instead}"
    if first["type"] == "extra_forbidden":
        return f"field {path!r} is unknown"
    if first["type"] == "bytes_type":
        return f"field {path!r}: bytes are base64 text or a list of 0 to 255, got {_show(first['input'])}"
    if first["type"] == "model_type":
        return f"field {path!r} is an object with fields of its own, got {_show(first['input'])}"
    return f"field {path!r}: {first['msg'][:1].lower()}{first['msg'][1:]}, got {_show(first['input'])}"


@lru_cache(maxsize=1024)
def _holds_bytes(message_type: type[Message]) -> bool:
    """Return whether it contains bytes, for which pydantic uses another base64 alphabet."""
    types = (message_type, *nested_types(message_type))
    return any(field.is_base64 for nested in types for field in fields_of(nested))


def _value_to_json(value: object, *, finite: bool = True) -> JsonValue:
    if isinstance(value, Message):
        form = value.json_form()
        return message_to_json(value, finite=finite) if form is value else _value_to_json(form, finite=finite)
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if isinstance(value, NumericArray) and value.buffer.format != "d":
        return value.tolist()
    if isinstance(value, (tuple, NumericArray)):
        return [_value_to_json(item, finite=finite) for item in value]
    if isinstance(value, float):
        return value if not finite or math.isfinite(value) else None
    if isinstance(value, bool | int | str | None):
        return value
    raise TypeMismatchError(f"{value!r} is not a valid message value")


def _fields_from_json(message_type: type[Message], value: Mapping[str, object]) -> dict[str, object]:
    known = fields_by_name(message_type)
    fields = {name: _value_from_json(known[name], item) for name, item in value.items() if name in known}
    if len(fields) < len(value):  # names only one unknown field: a flood would be expensive
        unknown = next(name for name in value if name not in known)
        fields[unknown] = value[unknown]
    return fields


def _known_fields(message_type: type[Message], value: Any) -> Any:
    """Return the JSON value of a message, or of a list of messages, without unknown fields."""
    if isinstance(value, list):
        return [_known_fields(message_type, item) for item in value]
    if not isinstance(value, Mapping):
        return value
    known = fields_by_name(message_type)
    return {
        name: item if (inner := known[name].message) is None else _known_fields(inner, item)
        for name, item in value.items()
        if name in known
    }


def _numbers_from_json(field: FieldDefinition, value: list[object]) -> list[object]:
    """Return *value* with NaN for null, if its numbers are real."""
    has_null = field.ros_type in _REAL and None in value
    return [math.nan if item is None else item for item in value] if has_null else value


def _value_from_json(field: FieldDefinition, value: object) -> object:
    if field.is_bytes or (field.is_numeric and isinstance(value, str)):
        with suppress(ValueError, TypeError):
            if isinstance(value, str):
                return base64.b64decode(value, validate=True)
            if isinstance(value, list):
                return bytes(value)
        return value  # validation then names it
    if field.is_numeric and isinstance(value, list):
        return _numbers_from_json(field, value)
    if field.is_array and isinstance(value, list):
        return tuple(_element_from_json(field, item) for item in value)
    return _element_from_json(field, value)


def _element_from_json(field: FieldDefinition, value: object) -> object:
    if field.message is not None and isinstance(value, Mapping):
        return _fields_from_json(field.message, value)
    if field.choices is not None and isinstance(value, str) and value in tuple(field.choices):
        return field.choices(value)
    if isinstance(value, str) and not value.isascii():
        try:
            value.encode()
        except UnicodeEncodeError:
            return value.encode(errors="surrogatepass")  # a lone surrogate, which validation refuses as bytes
        return value
    if value is None and field.ros_type in _REAL:
        return math.nan
    return value


def _show(value: object) -> str:
    shown = repr(value)
    return shown if len(shown) <= 60 else f"{shown[:57]}..."  # enough to recognise a value
