"""The bounded store between the link and the one task that reads.

Overflow: messages of QoS 0 are bounded in number and bytes, and the oldest of them go first. Messages of QoS 1 and 2
are never dropped here; the broker holds back more of them until some are acknowledged.
"""

from __future__ import annotations

from collections import deque

import anyio

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.message import MqttMessage

__all__ = ["Inbox"]


class Inbox:
    """Messages in order of arrival; `put` never waits, `take` waits for at least one.

    Args:
        max_messages: Most messages of QoS 0.
        max_bytes: Most bytes of such messages, topics and payloads; a single message may exceed it.

    Attributes:
        dropped: Messages of QoS 0 dropped so far.
    """

    def __init__(self, max_messages: int, max_bytes: int) -> None:
        self._max_messages = max_messages
        self._max_bytes = max_bytes
        self._messages: deque[MqttMessage] = deque()
        self._droppable = 0
        self._droppable_bytes = 0
        self._ended: LinkError | RefusedError | None = LinkError("not connected yet")
        self._wake: anyio.Event | None = None
        self.dropped = 0

    def put(self, message: MqttMessage) -> None:
        """Add a message, and make room for it if need be."""
        self._messages.append(message)
        if message.qos == 0:
            self._droppable += 1
            self._droppable_bytes += len(message.topic) + len(message.payload)
            while self._droppable > 1 and (
                self._droppable > self._max_messages or self._droppable_bytes > self._max_bytes
            ):
                self._drop_oldest()
        if self._wake is not None:
            self._wake_up()

    async def take(self) -> list[MqttMessage]:
        """Everything that is there, oldest first.

        Raises:
            LinkError: The store is empty and nothing more will come before `reopen`.
        """
        while not self._messages:
            if self._ended is not None:
                raise LinkError(f"no more messages: {self._ended}") from self._ended
            if self._wake is None:
                self._wake = anyio.Event()
            await self._wake.wait()
        taken = list(self._messages)
        self._messages.clear()
        self._droppable = self._droppable_bytes = 0
        return taken

    def end(self, reason: LinkError | RefusedError) -> None:
        """Nothing more will come, because of *reason*; what is there can still be taken."""
        self._ended = reason
        self._wake_up()

    def reopen(self, *, resumed: bool) -> None:
        """Messages will come again; in a *resumed* session the broker repeats those of QoS 1 that wait here."""
        self._ended = None
        if resumed:
            self._messages = deque(message for message in self._messages if message.qos != 1)

    def _wake_up(self) -> None:
        if self._wake is not None:
            self._wake.set()
            self._wake = None

    def _drop_oldest(self) -> None:
        index = next(index for index, message in enumerate(self._messages) if message.qos == 0)
        self._droppable -= 1
        self._droppable_bytes -= _size(self._messages[index])
        del self._messages[index]
        self.dropped += 1


def _size(message: MqttMessage) -> int:
    return len(message.topic) + len(message.payload)
