"""Memory of the messages that wait for clients, over all of them. No I/O."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, final

from homebot.mqtt.broker.message import BrokerMessage

__all__ = ["ENTRY", "QueuePool"]

ENTRY: Final = 200
"""Bytes that a place in a queue takes, about."""

_MESSAGE: Final = 600  # bytes that a message takes beside its topic, payload and properties, about


@final
class QueuePool:
    """The bytes of all messages that wait, or are not acknowledged; a message that waits for many counts once.

    Args:
        max_bytes: The bound.

    Attributes:
        used: The bytes now.
        on_overrun: Called when they are more than the bound; it makes room.
    """

    __slots__ = ("_max_bytes", "on_overrun", "used")

    def __init__(self, max_bytes: int) -> None:
        self.used = 0
        self.on_overrun: Callable[[], None] | None = None
        self._max_bytes = max_bytes

    @property
    def is_overrun(self) -> bool:
        """True if it is more than the bound."""
        return self.used > self._max_bytes

    def hold(self, message: BrokerMessage) -> None:
        """*message* has got one more place."""
        self.used += ENTRY
        message.holders += 1
        if message.holders == 1:
            self.used += message.size + _MESSAGE
        if self.used > self._max_bytes and self.on_overrun is not None:
            self.on_overrun()

    def release(self, message: BrokerMessage) -> None:
        """*message* has one place less."""
        self.used -= ENTRY
        message.holders -= 1
        if not message.holders:
            self.used -= message.size + _MESSAGE

    def add(self, size: int) -> None:
        """Something else than a message has got a place; below 0 where it has gone."""
        self.used += size
