"""Messages in JSON form, with attribute access.

They are typed like the messages, ``cast("Device", JsonMessage(fields))``: importing these, and validating thousands of
devices again, would take longer than the rest of a command.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast, final

from homebot.errors import WireError

if TYPE_CHECKING:
    from homebot.messages.message import Message


@final
class JsonMessage:
    """One message; its fields are attributes, and nested messages work the same way."""

    __slots__ = ("_fields",)

    def __init__(self, fields: Mapping[str, object]) -> None:
        self._fields = fields

    def __getattr__(self, name: str) -> object:
        try:
            return _read(self._fields[name])
        except KeyError:
            raise WireError(f"homebot answered without the field {name}; is it of another version?") from None


def fields_of(message: Message) -> Mapping[str, object]:
    """Return the JSON fields of *message*, a :class:`JsonMessage`."""
    return cast("JsonMessage", message)._fields


def _read(value: object) -> object:
    if isinstance(value, dict):
        return JsonMessage(value)
    if isinstance(value, list):
        return [_read(item) for item in value]
    return value
