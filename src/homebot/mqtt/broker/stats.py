"""The broker's counters, and its losses in words. No I/O."""

from __future__ import annotations

from collections import deque
from dataclasses import asdict, dataclass
from typing import Final, final

from homebot.support.counters import fault, loss


@dataclass(slots=True)
class Counters:
    """Counters since the broker was created, which never decrease.

    Attributes:
        dropped_qos0: QoS 0 messages for a client with a full socket.
        dropped_offline: The oldest messages displaced from the queue of an absent client.
        dropped_overrun: Messages refused for a connected client that is too slow, or after their publisher left.
        logins_slowed: Login attempts delayed after wrong passwords from their host.
        logins_pushed_out: Connections closed before their login, because others needed their place.
        unread_given_up: Connections closed because their packet stayed incomplete while there was no room for others.
        clients_stalled: Connections closed because the client made no progress while publishers that cannot be refused
            waited for it.
    """

    connections_accepted: int = 0
    connections_refused: int = fault()
    connections_failed: int = fault()
    connections_closed: int = 0
    messages_received: int = 0
    messages_sent: int = 0
    dropped_qos0: int = loss()
    dropped_offline: int = loss()
    dropped_overrun: int = loss()
    dropped_too_large: int = loss()
    dropped_expired: int = 0
    dropped_refused: int = fault()
    subscriptions_refused: int = fault()
    retained_refused: int = fault()
    sessions_evicted: int = 0
    logins_failed: int = fault()
    logins_slowed: int = 0
    logins_pushed_out: int = 0
    unread_given_up: int = 0
    holds: int = 0
    clients_stalled: int = 0


@dataclass(slots=True, kw_only=True)
class BrokerStats(Counters):
    """A snapshot of the broker: its :class:`Counters` and its current content.

    Attributes:
        clients: Connected clients, and those that have left messages to forward.
        retained_bytes: Bytes of retained topics, payloads and properties.
        waiting_work: Pieces of work waiting for a later turn of the event loop.
    """

    clients: int
    sessions: int
    subscriptions: int
    retained_messages: int
    retained_bytes: int
    queued_messages: int
    waiting_work: int

    @classmethod
    def of(cls, counters: Counters, **held: int) -> BrokerStats:
        """Combine *counters* with the current content."""
        return cls(**asdict(counters), **held)


_TEXTS: Final = {
    "dropped_qos0": "at QoS 0 for clients that read too slowly",
    "dropped_offline": "for clients that were away too long",
    "dropped_overrun": "for clients that stayed too slow",
    "dropped_too_large": "too large for their clients",
    "retained_refused": "to be retained, because the limit was reached",
}
"""The counters that are losses: without expired messages and those refused by a policy."""

_KEPT: Final = 60

Losses = tuple[int, ...]


def loss_text(counters: Counters, before: Losses = ()) -> str:
    """Return ``5 messages (3 at QoS 0 for clients that read too slowly, 2 too large for their clients)``.

    Returns:
        The text; empty if nothing was lost.
    """
    old = before or (0,) * len(_TEXTS)
    news = {text: now - then for text, now, then in zip(_TEXTS.values(), _losses(counters), old, strict=True)}
    total = sum(news.values())
    if not total:
        return ""
    parts = ", ".join(f"{count} {words}" for words, count in news.items() if count)
    return f"{total} message{'s' if total > 1 else ''} ({parts})"


@final
class LossReport:
    """The losses since the last report, and those of the last sixty reports."""

    def __init__(self, counters: Counters) -> None:
        self._counters = counters
        self._before: deque[Losses] = deque([_losses(counters)], maxlen=_KEPT)

    @property
    def recent(self) -> str:
        """Recent losses in words; empty if there are none."""
        return loss_text(self._counters, self._before[0])

    def next(self) -> str:
        """Return the losses since the last call in words; empty if there are none."""
        text = loss_text(self._counters, self._before[-1])
        self._before.append(_losses(self._counters))
        return text


def _losses(counters: Counters) -> Losses:
    return tuple(getattr(counters, name) for name in _TEXTS)
