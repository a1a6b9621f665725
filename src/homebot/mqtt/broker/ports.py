"""The broker's ports: transport, connection and topic policy."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final, Protocol, final

from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topics import topic_matches

_BRIDGE_STATE: Final = "$SYS/broker/connection/+/state"


class Transport(Protocol):
    """A client's connection as the broker sees it: a socket, or a pair of queues in memory.

    The carrier calls the peer's ``writable()`` when :attr:`write_blocked` has become False.
    """

    @property
    def write_blocked(self) -> bool:
        """True if the peer reads more slowly than bytes are written, so that anything that can wait should."""

    @property
    def address(self) -> str:
        """The peer's address, for the log."""

    def write(self, data: bytes) -> None:
        """Queue *data* for sending in order; ignored after a close."""

    def pause_reading(self) -> None:
        """Stop reading from the peer."""

    def resume_reading(self) -> None:
        """Read from the peer again."""

    def close(self, *, linger: bool) -> None:
        """Close after sending all written data.

        Args:
            linger: Whether to drain incoming bytes for a moment, as otherwise the reason may be lost.
        """


class ConnectionHandler(Protocol):
    """The events of one connection; implemented by :class:`Peer` and its wrappers."""

    @property
    def client_text(self) -> str:
        """Name of the client in the log."""

    def receive(self, data: bytes) -> None:
        """Handle bytes from the client."""

    def writable(self) -> None:
        """Go on writing: the link takes bytes again."""

    def lost(self) -> None:
        """End after the loss of the link."""

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients are sent *reason*."""


class ConnectedClient(Protocol):
    """A client's connection as the rest of the broker sees it; implemented by a peer."""

    @property
    def address(self) -> str:
        """The peer's address."""

    @property
    def unread(self) -> int:
        """The bytes of an incomplete packet."""

    @property
    def will_bytes(self) -> int:
        """The size of its will."""

    def make_room(self) -> None:
        """End the connection before its login, because another one needs its place."""

    def refuse_unread(self) -> None:
        """End the connection: its incomplete packet needs too much room."""

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients are sent *reason*."""

    def make_way(self, newcomer: ConnectedClient) -> bool:
        """End the connection, because *newcomer* has the same client id; False if it has to wait to be called."""

    def log_in(self) -> None:
        """Log in after the wait."""


class BrokerPolicy(Protocol):
    """Answers for each request of a logged-in client."""

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002 - the protocol's own word
        """Return success, or the failure for SUBACK of *filter* (``$share/GROUP/`` included)."""

    def publish(self, client_id: str, topic: str) -> ReasonCode:
        """Return success, or the failure for PUBACK or PUBREC; before MQTT 5 the message is silently dropped."""


@final
class RefusedFilters:
    """A policy that refuses subscriptions to some literal filters with 0x80, as an access list would.

    Below ``$SYS``, the topics of the broker itself, clients may only publish the connection state of a bridge, as with
    Mosquitto; MQTT 5.0, section 4.7.2, discourages exchanging messages there.
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
