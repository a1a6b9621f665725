"""Messages of which a client leaves out fields; in ROS these are zero, false or empty. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.messages.definition import FieldDefinition, fields_of
from homebot.messages.message import Message

__all__ = ["completed"]

_ZEROS: Final[Mapping[str, object]] = {"bool": False, "string": "", "float32": 0.0, "float64": 0.0}


def completed(message_type: type[Message], values: Mapping[str, object]) -> tuple[dict[str, object], tuple[str, ...]]:
    """Return *values* with the fields that are missing, and their names, with dots where they are of messages inside.

    A field with a default in *message_type* is not missing. A text that has to be one of an enumeration stays missing.
    """
    whole, names = dict(values), []
    for field in fields_of(message_type):
        if field.name in whole:
            whole[field.name], inner = _completed_field(field, whole[field.name])
            names += [f"{field.name}.{name}" for name in inner]
        elif message_type.model_fields[field.name].is_required() and field.choices is None:
            whole[field.name] = _zero(field)
            names.append(field.name)
    return whole, tuple(names)


def _completed_field(field: FieldDefinition, value: object) -> tuple[object, tuple[str, ...]]:
    if field.message is None:
        return value, ()
    if isinstance(value, Mapping):
        return completed(field.message, value)
    if not isinstance(value, list):
        return value, ()
    parts = [completed(field.message, one) if isinstance(one, Mapping) else (one, ()) for one in value]
    return [one for one, _ in parts], tuple(dict.fromkeys(name for _, inner in parts for name in inner))


def _zero(field: FieldDefinition) -> object:
    zero = _ZEROS.get(field.ros_type, 0) if field.message is None else completed(field.message, {})[0]
    return [zero] * (field.size or 0) if field.is_array else zero
