"""Bytes that all clients together may hold: in queues, in incomplete packets, and for their sockets. No I/O."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol, final

from homebot.mqtt.broker.message import BrokerMessage

__all__ = ["ENTRY", "QueuePool", "SlowSocket", "UnreadMark", "UnreadPackets", "UnsentBytes"]

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
        """Count one more place of *message*."""
        self.used += ENTRY
        message.holders += 1
        if message.holders == 1:
            self.used += message.size + _MESSAGE
        if self.used > self._max_bytes and self.on_overrun is not None:
            self.on_overrun()

    def release(self, message: BrokerMessage) -> None:
        """Count one place less of *message*."""
        self.used -= ENTRY
        message.holders -= 1
        if not message.holders:
            self.used -= message.size + _MESSAGE

    def add(self, size: int) -> None:
        """Count the place of something else than a message; below 0 where it has gone."""
        self.used += size


@final
class UnreadPackets:
    """The bytes of incomplete packets, bounded over all connections.

    Beyond the bound, the packet that has been incomplete longest loses its connection: an honest packet is complete
    sooner than one that is only begun.

    Args:
        max_bytes: The bound.
        least: Fewer bytes of one connection are not counted: nearly every read cuts a packet somewhere.
    """

    def __init__(self, max_bytes: int, least: int = 1) -> None:
        self._max_bytes = max_bytes
        self._least = least
        self._held: dict[Callable[[], None], int] = {}  # in the order in which they became incomplete
        self.size = 0

    def note(self, give_up: Callable[[], None], held: int) -> None:
        """Note that a connection holds *held* bytes of an incomplete packet; 0 where it is complete, or has gone.

        Args:
            give_up: Ends that connection in any turn; it records 0 then.
            held: The bytes.
        """
        if held < self._least:
            self.size -= self._held.pop(give_up, 0)
            return
        self.size += held - self._held.get(give_up, 0)
        self._held[give_up] = held
        while self.size > self._max_bytes and self._held:
            oldest = next(iter(self._held))
            self.size -= self._held.pop(oldest)
            oldest()


@final
class UnreadMark:
    """The bytes that one connection holds unread.

    Attributes:
        size: The bytes that were noted last.
    """

    __slots__ = ("_give_up", "_packets", "size")

    def __init__(self, packets: UnreadPackets, give_up: Callable[[], None]) -> None:
        self._packets = packets
        self._give_up = give_up
        self.size = 0

    def note(self, held: int) -> None:
        """Note how many bytes wait for the rest of their packet now."""
        self.size = held
        self._packets.note(self._give_up, held)

    def move(self, packets: UnreadPackets) -> None:
        """Count in *packets* from now on."""
        self.note(0)
        self._packets = packets


class SlowSocket(Protocol):
    """A socket that takes bytes slower than they come."""

    @property
    def unsent(self) -> int:
        """The bytes that wait for it now."""
        ...

    def give_up(self) -> None:
        """Cut it."""
        ...


@final
class UnsentBytes:
    """The bytes that wait for sockets; beyond the bound, the one for which most wait is cut.

    Args:
        max_bytes: The bound.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._waiting: dict[SlowSocket, int] = {}
        self.size = 0

    def note(self, socket: SlowSocket, size: int) -> None:
        """Note how many bytes wait for *socket* now; 0 where it has caught up or gone."""
        self.size += size - self._waiting.pop(socket, 0)
        if size:
            self._waiting[socket] = size
        if self.size > self._max_bytes:
            self._waiting = {each: each.unsent for each in self._waiting}
            self.size = sum(self._waiting.values())
            while self.size > self._max_bytes:
                largest = max(self._waiting, key=self._waiting.__getitem__)
                self.size -= self._waiting.pop(largest)
                largest.give_up()
