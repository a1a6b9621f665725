"""The messages that wait for one client."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple, final

from homebot.mqtt.broker.message import Message

__all__ = ["MessageQueue", "Parcel"]


class Parcel(NamedTuple):
    """A message as one client is to get it.

    Attributes:
        message: The message.
        qos: What it is sent with, 0 to 2.
        retain: The retain flag it is sent with.
        identifiers: The subscription identifiers of all subscriptions that matched.
        share: Group and filter where it came by a shared subscription.
    """

    message: Message
    qos: int
    retain: bool
    identifiers: tuple[int, ...] = ()
    share: tuple[str, str] | None = None


@final
class MessageQueue:
    """A first-in-first-out queue that knows how full it is, but leaves it to its owner what to do then.

    Args:
        max_messages: Bound in messages.
        max_bytes: Bound in bytes of payload and topic; a single larger message still fits into an empty queue.
    """

    __slots__ = ("_bytes", "_max_bytes", "_max_messages", "_parcels", "_qos0")

    def __init__(self, max_messages: int, max_bytes: int) -> None:
        self._parcels: deque[Parcel] = deque()
        self._bytes = 0
        self._qos0 = 0
        self._max_messages = max_messages
        self._max_bytes = max_bytes

    def __len__(self) -> int:
        return len(self._parcels)

    @property
    def full(self) -> bool:
        """Whether another message would be over the bound."""
        return len(self._parcels) >= self._max_messages or self._bytes >= self._max_bytes

    @property
    def high(self) -> bool:
        """Whether three quarters of the bound are reached: time to slow down who fills it."""
        return 4 * len(self._parcels) >= 3 * self._max_messages or 4 * self._bytes >= 3 * self._max_bytes

    @property
    def low(self) -> bool:
        """Whether half of the bound is free again."""
        return 2 * len(self._parcels) <= self._max_messages and 2 * self._bytes <= self._max_bytes

    @property
    def holds_qos0(self) -> bool:
        """Whether QoS 0 messages wait, which later ones must not overtake."""
        return self._qos0 > 0

    @property
    def first(self) -> Parcel:
        """The next to be sent."""
        return self._parcels[0]

    def append(self, parcel: Parcel) -> None:
        """Add at the end, whatever the bound says."""
        self._parcels.append(parcel)
        self._bytes += parcel.message.size
        self._qos0 += not parcel.qos

    def popleft(self) -> Parcel:
        """Take the first."""
        parcel = self._parcels.popleft()
        self._bytes -= parcel.message.size
        self._qos0 -= not parcel.qos
        return parcel

    def drop_qos0(self) -> None:
        """Forget the QoS 0 messages: their client has gone."""
        if self._qos0:
            for _ in range(len(self._parcels)):
                parcel = self.popleft()
                if parcel.qos:
                    self.append(parcel)

    def clear(self) -> list[Parcel]:
        """Take all."""
        parcels = list(self._parcels)
        self._parcels.clear()
        self._bytes = self._qos0 = 0
        return parcels
