"""Server-sent events: a stream of bytes becomes events. Pure.

Source: HTML Living Standard, section 9.2 "Server-sent events" (parsing and interpreting an event stream).
"""

from __future__ import annotations

import codecs
from dataclasses import dataclass

from homebot.errors import WireError

__all__ = ["EventStreamParser", "ServerEvent"]

_MOST_RETRY = 3600.0
_BOM = "\ufeff"


@dataclass(frozen=True, slots=True)
class ServerEvent:
    """One event of a stream.

    Attributes:
        kind: Its type; ``message`` where the server names none.
        data: Its data; lines are joined by line feeds.
        id: The id to go on from after a break: that of this event, or of the last one that had any.
    """

    kind: str
    data: str
    id: str


class EventStreamParser:
    """Makes events of the bytes of a stream, however they are cut.

    Args:
        max_event: Longest event, in bytes.

    Attributes:
        last_id: The id of the last event that had one.
        retry: Seconds after which the server wants to be asked again when the stream has ended; None if it does not
            say.
    """

    def __init__(self, max_event: int) -> None:
        self.last_id = ""
        self.retry: float | None = None
        self._max_event = max_event
        self._decoder = codecs.getincrementaldecoder("utf-8")(errors="replace")
        self._rest = ""
        self._kind = ""
        self._data: list[str] = []
        self._size = 0
        self._id = ""
        self._is_start = True
        self._ended_with_return = False

    def feed(self, chunk: bytes) -> tuple[ServerEvent, ...]:
        """Take the next bytes, and return the events that they complete.

        Raises:
            WireError: An event is too long; the stream cannot be read on.
        """
        text = self._decoder.decode(chunk)
        if self._is_start and text:
            text, self._is_start = text.removeprefix(_BOM), False
        if self._ended_with_return and text:  # the line ended with CR LF, which two chunks hold
            text, self._ended_with_return = text.removeprefix("\n"), False
        if "\r" in text:
            self._ended_with_return = text.endswith("\r")
            text = text.replace("\r\n", "\n").replace("\r", "\n")
        if "\n" not in text:
            self._rest += text
            self._check_size(len(self._rest))
            return ()
        *lines, rest = (self._rest + text).split("\n")
        self._rest = rest
        found = [event for line in lines if (event := self._take(line)) is not None]
        self._check_size(len(rest))
        return tuple(found)

    def _take(self, line: str) -> ServerEvent | None:
        if not line:
            return self._dispatch()
        self._size += len(line)
        self._check_size(0)
        name, _, value = line.partition(":")
        value = value.removeprefix(" ")
        match name:
            case "event":
                self._kind = value
            case "data":
                self._data.append(value)
            case "id" if "\0" not in value:
                self._id = value
            case "retry" if value.isascii() and value.isdigit() and len(value) < 10:
                self.retry = min(int(value) / 1000, _MOST_RETRY)
            case _:
                pass  # a comment begins with a colon; the standard has unknown fields ignored
        return None

    def _dispatch(self) -> ServerEvent | None:
        self.last_id = self._id
        event = ServerEvent(self._kind or "message", "\n".join(self._data), self.last_id) if self._data else None
        self._kind, self._size = "", 0
        self._data.clear()
        return event

    def _check_size(self, more: int) -> None:
        if self._size + more > self._max_event:
            raise WireError(f"an event is longer than {self._max_event} bytes")
