"""Compact form of sightings and reports that repeat the last one of their source, a tenth of the text. Pure.

Otherwise a device that sends its state every second makes up nearly all of a recording.
"""

from typing import Final, Literal, TypeAlias, final

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.messages.message import Message
from homebot.support.bounded_map import BoundedMap

_MAX_SOURCES: Final = 20_000
"""The limit of sources with a known last message; the least recent is forgotten, and later recorded in full again."""

_SECOND: Final = 1_000_000_000
_TIMES: Final = frozenset({"seen_at", "expires_at", "received_at", "heard_at"})

_Source: TypeAlias = tuple[Literal["sighting", "report"], str, str, str]


class Repetition(Message):
    """A repetition of the last sighting or report of a source at another time; a sighting has the same lifetime."""

    of: Literal["sighting", "report"]
    gateway: str
    key: str
    stream: str = ""
    at: Time


@final
class Repetitions:
    """The last messages of all sources, in a recorder, and in a reader that processes the same messages in order."""

    def __init__(self) -> None:
        self._last: BoundedMap[_Source, Sighting | Report] = BoundedMap(_MAX_SOURCES)

    def shortened(self, message: Message) -> Message:
        """Return a :class:`Repetition` if *message* is one, and any other message unchanged."""
        if not isinstance(message, Sighting | Report):
            return message
        source = _source(message)
        last = self._last.get(source)
        self._last[source] = message
        if last is None or not _is_same(last, message):
            return message
        kind, gateway, key, stream = source
        at = message.seen_at if isinstance(message, Sighting) else message.received_at
        return Repetition(of=kind, gateway=gateway, key=key, stream=stream, at=at)

    def whole(self, message: Message) -> Message:
        """Return the message behind a :class:`Repetition`, and any other unchanged.

        Raises:
            UsageError: There is no message before it.
        """
        if isinstance(message, Sighting | Report):
            self._last[_source(message)] = message
        if not isinstance(message, Repetition):
            return message
        source = message.of, message.gateway, message.key, message.stream
        match self._last.get(source):
            case Sighting() as last:
                sec, nanosec = divmod(_nanoseconds(message.at) + _lasts(last), _SECOND)
                again: Sighting | Report = last.model_copy(
                    update={"seen_at": message.at, "expires_at": Time(sec=sec, nanosec=nanosec), "heard_at": 0.0}
                )
            case Report() as last:
                again = last.model_copy(update={"received_at": message.at, "heard_at": 0.0})
            case _:
                raise UsageError(f"repeats a {message.of} of {message.key[:60]!r}, but there is none before")
        self._last[source] = again
        return again

    def forget(self) -> None:
        """Forget all messages, so that each source is recorded in full again, because a line was lost."""
        self._last.clear()


def _source(message: Sighting | Report) -> _Source:
    if isinstance(message, Sighting):
        return "sighting", message.gateway, message.key, ""
    return "report", message.gateway, message.key, message.stream


def _is_same(last: Sighting | Report, message: Sighting | Report) -> bool:
    before, now = last.__dict__, message.__dict__
    if any(before[name] != value for name, value in now.items() if name not in _TIMES):
        return False
    if isinstance(last, Sighting) and isinstance(message, Sighting):
        return _lasts(last) == _lasts(message)
    return True


def _lasts(sighting: Sighting) -> int:
    return _nanoseconds(sighting.expires_at) - _nanoseconds(sighting.seen_at)


def _nanoseconds(time: Time) -> int:
    return time.sec * _SECOND + time.nanosec
