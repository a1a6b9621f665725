"""Ports of the broker: transport of bytes, endpoint of a connection, and policy of topics."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final, Protocol, final

from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topics import topic_matches

__all__ = ["BrokerPolicy", "ConnectedClient", "ConnectionHandler", "RefusedFilters", "Transport"]

_BRIDGE_STATE: Final = "$SYS/broker/connection/+/state"


class Transport(Protocol):
    """One client's connection as the broker sees it: a socket, or a pair of queues in memory.

    The carrier calls the peer's ``writable()`` when :attr:`write_blocked` has become False.
    """

    @property
    def write_blocked(self) -> bool:
        """True if the far side takes bytes slower than they come: nothing more should be written that can wait."""
        ...

    @property
    def address(self) -> str:
        """The far side as text, for the log."""
        ...

    def write(self, data: bytes) -> None:
        """Send *data* in order, sooner or later; nothing after a close."""
        ...

    def pause_reading(self) -> None:
        """Take no more bytes from the far side."""
        ...

    def resume_reading(self) -> None:
        """Take bytes again."""
        ...

    def close(self, *, linger: bool) -> None:
        """Send all written data, then close.

        Args:
            linger: The far side may still be sending: drain it for a moment, or the reason is lost.
        """
        ...


class ConnectionHandler(Protocol):
    """A port for the events of one connection; :class:`Peer` and its wrappers implement it."""

    @property
    def client_text(self) -> str:
        """Name of the client in the log."""
        ...

    def receive(self, data: bytes) -> None:
        """Handle bytes from the client."""
        ...

    def writable(self) -> None:
        """Go on writing: the link takes bytes again."""
        ...

    def lost(self) -> None:
        """End, as the link is gone."""
        ...

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients are sent *reason*."""
        ...


class ConnectedClient(Protocol):
    """The connection of a client as the rest of the broker sees it; a peer implements it."""

    @property
    def address(self) -> str:
        """The far side."""
        ...

    @property
    def unread(self) -> int:
        """The bytes of an incomplete packet."""
        ...

    @property
    def will_bytes(self) -> int:
        """The size of its will."""
        ...

    def make_room(self) -> None:
        """End the connection before its login: another one needs its place."""
        ...

    def refuse_unread(self) -> None:
        """End the connection: its incomplete packet needs too much room."""
        ...

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients are sent *reason*."""
        ...

    def make_way(self, newcomer: ConnectedClient) -> bool:
        """End the connection, because *newcomer* has the same client id; False if it has to wait to be called."""
        ...

    def log_in(self) -> None:
        """Log in, after a wait."""
        ...


class BrokerPolicy(Protocol):
    """Answers for each request of a logged-in client."""

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002 - the protocol's own word
        """Return success, or the failure that SUBACK is to carry for *filter* (``$share/GROUP/`` included)."""
        ...

    def publish(self, client_id: str, topic: str) -> ReasonCode:
        """Return success, or the failure that PUBACK or PUBREC is to carry; before MQTT 5 the message just vanishes."""
        ...


@final
class RefusedFilters:
    """Refuses subscriptions to some filters, as written, with 0x80, as an access list would.

    Of the topics of the broker itself, those below ``$SYS``, clients may publish the one where a bridge says whether it
    is connected, as at Mosquitto; MQTT 5.0, section 4.7.2, asks that clients exchange no messages there.
    """

    def __init__(self, filters: Collection[str] = ()) -> None:
        self._filters = frozenset(filters)

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002, ARG002 - fills the port
        """Return 0x80 for the refused filters."""
        return ReasonCode.UNSPECIFIED_ERROR if filter in self._filters else ReasonCode.SUCCESS

    def publish(self, client_id: str, topic: str) -> ReasonCode:  # noqa: ARG002 - fills the port
        """Return 0x87 for the topics of the broker."""
        if topic.startswith("$SYS/") and not topic_matches(_BRIDGE_STATE, topic):
            return ReasonCode.NOT_AUTHORIZED
        return ReasonCode.SUCCESS
