"""Server-sent events: a stream of bytes becomes events. Pure.

Source: HTML Living Standard, section 9.2 "Server-sent events" (parsing and interpreting an event stream).
"""

import codecs
from dataclasses import dataclass

from homebot.errors import WireError

_BOM = "\ufeff"


@dataclass(frozen=True, slots=True)
class ServerEvent:
    """One event of a stream.

    Attributes:
        kind: Its type; ``message`` where the server names none.
    """

    kind: str
    data: str


class EventStreamParser:
    """Parses events from the chunks of a stream."""

    def __init__(self, max_event: int) -> None:
        self._max_event = max_event
        self._decoder = codecs.getincrementaldecoder("utf-8")(errors="replace")
        self._rest = ""
        self._kind = ""
        self._data: list[str] = []
        self._size = 0
        self._is_start = True
        self._ended_with_return = False

    def feed(self, chunk: bytes) -> tuple[ServerEvent, ...]:
        """Add the next bytes, and return the events that they complete.

        Raises:
            WireError: An event is too long; the stream cannot be read on.
        """
        text = self._decoder.decode(chunk)
        if self._is_start and text:
            text, self._is_start = text.removeprefix(_BOM), False
        if self._ended_with_return and text:  # a CR LF that was split between two chunks
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
        events = [event for line in lines if (event := self._parse_line(line)) is not None]
        self._check_size(len(rest))
        return tuple(events)

    def _parse_line(self, line: str) -> ServerEvent | None:
        if not line:
            event = ServerEvent(self._kind or "message", "\n".join(self._data)) if self._data else None
            self._kind, self._size = "", 0
            self._data.clear()
            return event
        self._size += len(line)
        self._check_size(0)
        name, _, value = line.partition(":")
        value = value.removeprefix(" ")
        match name:
            case "event":
                self._kind = value
            case "data":
                self._data.append(value)
            case _:
                pass  # ids and pauses are for resumption; comments and unknown fields are ignored
        return None

    def _check_size(self, more: int) -> None:
        if self._size + more > self._max_event:
            raise WireError(f"an event is longer than {self._max_event} bytes")
