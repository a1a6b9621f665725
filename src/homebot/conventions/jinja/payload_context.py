"""One message as all its templates see it: its text, and what it says in JSON, looked at once."""

from __future__ import annotations

from typing import final

from homebot.conventions.jinja.undefined import UNDEFINED
from homebot.conventions.payload import MAX_LONG_STATE_BYTES, parse_json
from homebot.errors import WireError

__all__ = ["PayloadContext"]


@final
class PayloadContext:
    """The variables ``value`` and ``value_json`` of one message, to be shared by all templates that read it.

    Args:
        value: The text of the message.
    """

    __slots__ = ("_json", "value")

    def __init__(self, value: str) -> None:
        self.value = value
        self._json: object = _UNREAD

    @property
    def value_json(self) -> object:
        """JSON value of the text; :data:`UNDEFINED` where it is none that our border lets in."""
        if self._json is _UNREAD:
            try:
                self._json = parse_json(self.value, MAX_LONG_STATE_BYTES)
            except WireError:
                self._json = UNDEFINED
        return self._json


_UNREAD = object()
