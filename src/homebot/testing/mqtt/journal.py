"""The messages published by clients, for a test to expect; used on the broker's loop."""

import json
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import final

import anyio

from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.packets import NO_PROPERTIES, Properties
from homebot.mqtt.topics import topic_matches


@final
class PulseEvent:
    """An event that wakes all waiting tasks without staying set."""

    def __init__(self) -> None:
        self._next = anyio.Event()

    def ring(self) -> None:
        """Wake all waiting tasks."""
        self._next.set()
        self._next = anyio.Event()

    async def wait(self) -> None:
        """Wait for the next :meth:`ring`."""
        await self._next.wait()


Payload = bytes | str | Mapping[str, object] | Sequence[object]
"""Types of payloads: bytes, text as UTF-8, a dict or list as JSON."""

_MAX_TEXT = 200


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """A message published by a client; a will counts as its client's.

    Attributes:
        properties: The MQTT 5 properties.
    """

    topic: str
    payload: bytes = b""
    qos: int = 0
    retain: bool = False
    properties: Properties = NO_PROPERTIES
    client_id: str = ""

    @property
    def text(self) -> str:
        """The payload as UTF-8, with invalid bytes as U+FFFD."""
        return self.payload.decode(errors="replace")

    def json(self) -> object:
        """Return the payload parsed as JSON.

        Raises:
            ValueError: It is not JSON.
        """
        return json.loads(self.payload)

    def __str__(self) -> str:
        text = repr(self.text)
        if len(text) > _MAX_TEXT:
            text = f"{text[:_MAX_TEXT]}… ({len(self.payload)} bytes)"
        retain = ", retain" if self.retain else ""
        return f"{self.topic} {text} (QoS {self.qos}{retain}, from {self.client_id})"


Wanted = Payload | Callable[[RecordedMessage], bool] | None
"""The expectation of a test: None for anything, a dict or list to compare as JSON, or a function."""


def encode_payload(payload: Payload) -> bytes:
    """Return *payload* as bytes.

    Raises:
        TypeError: A value in it has no JSON form.
    """
    if isinstance(payload, bytes | bytearray | memoryview):
        return bytes(payload)
    if isinstance(payload, str):
        return payload.encode()
    return json.dumps(payload).encode()


def payload_matches(wanted: Wanted, message: RecordedMessage) -> bool:
    """Return whether *message* has the wanted payload."""
    if wanted is None:
        return True
    if callable(wanted):
        return wanted(message)
    if isinstance(wanted, bytes | bytearray | memoryview | str):
        return encode_payload(wanted) == message.payload
    try:
        return bool(message.json() == json.loads(encode_payload(wanted)))
    except ValueError:  # including bytes that are not text
        return False


_MAX_MESSAGES = 10_000  # beyond that the oldest is forgotten
_MAX_SHOWN = 5


@dataclass(slots=True)
class _Entry:
    message: RecordedMessage
    taken: bool = False


@final
class Journal:
    """The newest 10,000 messages in order; each is returned once."""

    def __init__(self) -> None:
        self.forgotten = 0
        self._entries: deque[_Entry] = deque()
        self._grown = PulseEvent()

    def record(self, message: BrokerMessage) -> None:
        """Record a message of a client; those of the test itself have no origin, and are ignored."""
        if not message.origin:
            return
        if len(self._entries) == _MAX_MESSAGES:
            self._entries.popleft()
            self.forgotten += 1
        seen = RecordedMessage(
            message.topic, message.payload, message.qos, message.retain, message.properties, message.origin
        )
        self._entries.append(_Entry(seen))
        self._grown.ring()

    def clear(self) -> None:
        """Forget everything; from any thread."""
        self._entries.clear()
        self.forgotten = 0

    async def pop(self, filter: str, wanted: Wanted, timeout: float) -> RecordedMessage | None:  # noqa: A002, ASYNC109 - the user's words
        """Remove and return the first matching message, waiting for it if necessary; None if none arrives."""
        with anyio.move_on_after(timeout):
            while (message := self._pop(filter, wanted)) is None:
                await self._grown.wait()
            return message
        return None

    def waiting(self, filter: str) -> list[RecordedMessage]:  # noqa: A002 - the protocol's own word
        """Return all unread messages on *filter*, in order."""
        return [
            entry.message
            for entry in self._entries.copy()
            if not entry.taken and topic_matches(filter, entry.message.topic)
        ]

    def near_misses(self, filter: str, wanted: Wanted, timeout: float) -> str:  # noqa: A002 - as above
        """Describe a missing message, and the received ones."""
        entries = self._entries.copy()
        here = [entry for entry in entries if topic_matches(filter, entry.message.topic)]
        there = [entry.message for entry in entries if not topic_matches(filter, entry.message.topic)]
        other = [entry.message for entry in here if not entry.taken]
        taken = [entry.message for entry in here if entry.taken and payload_matches(wanted, entry.message)]
        elsewhere = {message.topic: message for message in there}
        similar = get_close_matches(filter, elsewhere, n=_MAX_SHOWN, cutoff=0.5)
        lines = [f"no client published {_wanted_text(wanted)} on {filter} within {timeout:g} s"]
        lines += _section("received with another payload", other)
        lines += _section("an earlier expect() has taken already", taken)
        lines += _section("received on similar topics", [elsewhere[topic] for topic in similar])
        if len(lines) == 1:
            lines += _section("the last messages on other topics", list(elsewhere.values()))
        if len(lines) == 1:
            lines.append("no client published anything at all")
        return "\n".join(lines)

    def _pop(self, filter: str, wanted: Wanted) -> RecordedMessage | None:  # noqa: A002 - as above
        for entry in self._entries:
            message = entry.message
            if not entry.taken and topic_matches(filter, message.topic) and payload_matches(wanted, message):
                entry.taken = True
                return message
        return None


def _wanted_text(wanted: Wanted) -> str:
    return "a message" if wanted is None else getattr(wanted, "__name__", None) or repr(wanted)


def _section(title: str, messages: list[RecordedMessage]) -> list[str]:
    if not messages:
        return []
    more = len(messages) - _MAX_SHOWN
    shown = [f"    {message}" for message in messages[-_MAX_SHOWN:]]
    return [f"  {title}:", *([f"    … {more} earlier"] if more > 0 else []), *shown]
