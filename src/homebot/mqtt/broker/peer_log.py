"""Log of one connection. No I/O."""

from __future__ import annotations

from typing import final

from homebot.mqtt.broker.client_text import client_text, short
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.transport import Transport
from homebot.mqtt.packets import PacketError, ReasonCode

__all__ = ["PeerLog"]


@final
class PeerLog:
    """Warnings of one connection.

    Args:
        hub: The broker, which limits their rate.
        link: The connection.

    Attributes:
        client_id: Who it is, once logged in.
    """

    __slots__ = ("_hub", "_link", "client_id")

    def __init__(self, hub: BrokerState, link: Transport) -> None:
        self._hub = hub
        self._link = link
        self.client_id: str | None = None

    @property
    def client_text(self) -> str:
        """Name of the client in the log."""
        return client_text(self.client_id, self._link.address)

    def failed(self, error: PacketError) -> None:
        """The client did, or left undone, what ends the connection."""
        self._hub.warn(
            "broker.connection_failed",
            f"the broker cut off {self.client_text}: {short(error.problem)}",
            address=self._link.address,
            client_id=self.client_id,
            code=error.code.name.lower(),
            problem=error.problem,
        )

    def refused(self, client_id: str, reason: ReasonCode) -> None:
        """*client_id* was not let in."""
        self._hub.warn(
            "broker.login_refused",
            f"the broker did not let {client_text(client_id, self._link.address)} in: {reason.words}",
            address=self._link.address,
            client_id=client_id,
            reason=reason.name.lower(),
        )

    def pushed_out(self) -> None:
        """It had to go before its login."""
        address = self._link.address
        self._hub.warn(
            "broker.login_pushed_out",
            f"the broker closed the connection of {address}, which had not logged in: too many wait for that",
            address=address,
        )

    def too_large(self, topic: str, size: int, limit: int) -> None:
        """The client missed a message."""
        self._hub.warn(
            "broker.message_too_large",
            f"{self.client_text} missed a message on {short(topic)!r}: it has {size} bytes, "
            f"the client takes at most {limit}",
            address=self._link.address,
            client_id=self.client_id,
            topic=topic,
            size=size,
            limit=limit,
        )
