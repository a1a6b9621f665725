"""Packets of which only a part has come: how many bytes of them all connections together may hold. No I/O."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

__all__ = ["UnreadMark", "UnreadPackets"]


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
        """A connection now holds *held* bytes of an incomplete packet; 0 where it is complete, or has gone.

        Args:
            give_up: Ends that connection, whoever's turn it is; it notes 0 then.
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

    Args:
        packets: Where it counts.
        give_up: Ends the connection.

    Attributes:
        size: The bytes that were noted last.
    """

    __slots__ = ("_give_up", "_packets", "size")

    def __init__(self, packets: UnreadPackets, give_up: Callable[[], None]) -> None:
        self._packets = packets
        self._give_up = give_up
        self.size = 0

    def note(self, held: int) -> None:
        """So many bytes wait for the rest of their packet now."""
        self.size = held
        self._packets.note(self._give_up, held)

    def move(self, packets: UnreadPackets) -> None:
        """From now on it counts there."""
        self.note(0)
        self._packets = packets
