"""The newest packets between the test broker and its clients, in words."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, final

from homebot.mqtt.packets import Packet
from homebot.testing.mqtt.packet_text import packet_text

__all__ = ["PacketLog", "PacketRecord"]

MAX_PACKETS = 1000
"""How many are kept; beyond it the oldest is forgotten and counted."""


@dataclass(frozen=True, slots=True)
class PacketRecord:
    """One packet, or one event of a connection.

    Attributes:
        at: Seconds since the broker started.
        direction: ``in`` from a client, ``out`` to it, ``note`` an event such as a connection that was lost.
        client: Client id, or the address before the login.
        what: The packet, or the event in words.
    """

    at: float
    direction: Literal["in", "out", "note"]
    client: str
    what: Packet | str

    def __str__(self) -> str:
        text = self.what if isinstance(self.what, str) else packet_text(self.what)
        return f"{self.at:9.4f} s  {self.client:20}  {_ARROWS[self.direction]}  {text}"


@final
class PacketLog:
    """The newest 1,000 records; may be read from any thread.

    Args:
        now: The time in seconds; the log counts from its making.

    Attributes:
        total: How many there have been, the forgotten ones included.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self.total = 0
        self._now = now
        self._start = now()
        self._records: deque[PacketRecord] = deque(maxlen=MAX_PACKETS)

    @property
    def records(self) -> tuple[PacketRecord, ...]:
        """Packets that are kept, the oldest first."""
        return tuple(self._records.copy())

    def add(self, direction: Literal["in", "out", "note"], client: str, what: Packet | str) -> None:
        """Note something that happens now."""
        self.total += 1
        self._records.append(PacketRecord(self._now() - self._start, direction, client, what))

    def text(self, newest: int = MAX_PACKETS) -> str:
        """The newest records in lines, ``→`` to the broker and ``←`` from it."""
        shown = self.records[-newest:]
        left_out = self.total - len(shown)
        lines = [f"… {left_out} earlier packets"] if left_out else []
        return "\n".join([*lines, *map(str, shown)])


_ARROWS = {"in": "→", "out": "←", "note": "·"}
