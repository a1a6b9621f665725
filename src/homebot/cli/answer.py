"""Answers of homebot: messages as JSON has them, read by attribute.

Typed as the messages themselves, ``cast("Device", Answer(fields))``: to import these, and to check thousands of devices
once more, takes longer than all else that a command does.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast, final

from homebot.errors import WireError

if TYPE_CHECKING:
    from homebot.messages.message import Message

__all__ = ["Answer", "fields_of"]


@final
class Answer:
    """One message; its fields are attributes, and messages in them are answers as well.

    Args:
        fields: Its fields as JSON has them.
    """

    __slots__ = ("_fields",)

    def __init__(self, fields: Mapping[str, object]) -> None:
        self._fields = fields

    def __getattr__(self, name: str) -> object:
        try:
            return _answered(self._fields[name])
        except KeyError:
            raise WireError(f"homebot answered without the field {name}; is it of another version?") from None


def fields_of(message: Message) -> Mapping[str, object]:
    """Return the fields of an answer as JSON has them."""
    return cast("Answer", message)._fields


def _answered(value: object) -> object:
    if isinstance(value, dict):
        return Answer(value)
    if isinstance(value, list):
        return [_answered(one) for one in value]
    return value
