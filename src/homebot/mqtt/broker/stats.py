"""Counters of the broker."""

from __future__ import annotations

from dataclasses import asdict, dataclass

__all__ = ["BrokerStats", "Counters"]


@dataclass(slots=True)
class Counters:
    """Counts since the broker was made; only ever grow.

    Attributes:
        connections_accepted: Sockets accepted.
        connections_refused: Sockets or logins turned away.
        connections_failed: Connections closed because of what the client did or left undone.
        connections_closed: Connections that ended, whoever ended them.
        messages_received: PUBLISH packets taken from clients.
        messages_sent: PUBLISH packets written to clients.
        dropped_qos0: QoS 0 messages not sent to a client whose socket was full.
        dropped_offline: The oldest messages pushed out of the queue of an absent client.
        dropped_overrun: Messages refused for a connected client that stayed too slow, or whose publisher had gone.
        dropped_too_large: Messages larger than the client's Maximum Packet Size.
        dropped_expired: Messages whose expiry interval passed before they were sent.
        dropped_refused: Publishes a policy refused.
        subscriptions_refused: Subscriptions refused for want of room.
        retained_refused: Messages not retained for want of room.
        sessions_evicted: Sessions pushed out for want of room.
        logins_failed: Passwords that were wrong.
        logins_slowed: Attempts to log in that had to wait, after wrong passwords from their host.
        logins_pushed_out: Connections closed before their login, because others needed the place.
        unread_given_up: Connections closed because their packet stayed incomplete while there was no room for others.
        holds: Times a publisher was held back for a slow client.
        clients_stalled: Connections closed because the client took next to nothing while publishers that cannot be
            told no waited for it.
    """

    connections_accepted: int = 0
    connections_refused: int = 0
    connections_failed: int = 0
    connections_closed: int = 0
    messages_received: int = 0
    messages_sent: int = 0
    dropped_qos0: int = 0
    dropped_offline: int = 0
    dropped_overrun: int = 0
    dropped_too_large: int = 0
    dropped_expired: int = 0
    dropped_refused: int = 0
    subscriptions_refused: int = 0
    retained_refused: int = 0
    sessions_evicted: int = 0
    logins_failed: int = 0
    logins_slowed: int = 0
    logins_pushed_out: int = 0
    unread_given_up: int = 0
    holds: int = 0
    clients_stalled: int = 0


@dataclass(frozen=True, slots=True)
class BrokerStats:
    """A snapshot of the broker: the :class:`Counters`, and what it holds now.

    Attributes:
        clients: Clients connected now.
        sessions: Sessions kept now, connected or not.
        subscriptions: Subscriptions of all sessions.
        retained_messages: Retained messages.
        retained_bytes: Their topics, payloads and properties, in bytes.
        queued_messages: Messages waiting in all sessions.
    """

    clients: int
    sessions: int
    subscriptions: int
    retained_messages: int
    retained_bytes: int
    queued_messages: int
    connections_accepted: int
    connections_refused: int
    connections_failed: int
    connections_closed: int
    messages_received: int
    messages_sent: int
    dropped_qos0: int
    dropped_offline: int
    dropped_overrun: int
    dropped_too_large: int
    dropped_expired: int
    dropped_refused: int
    subscriptions_refused: int
    retained_refused: int
    sessions_evicted: int
    logins_failed: int
    logins_slowed: int
    logins_pushed_out: int
    unread_given_up: int
    holds: int
    clients_stalled: int

    @classmethod
    def of(cls, counters: Counters, **held: int) -> BrokerStats:
        """Join *counters* with what is held now."""
        return cls(**asdict(counters), **held)
