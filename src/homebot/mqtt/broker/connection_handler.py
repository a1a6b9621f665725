"""The port between whatever carries a client's bytes and what understands them."""

from __future__ import annotations

from typing import Protocol

from homebot.mqtt.packets import ReasonCode

__all__ = ["ConnectionHandler"]


class ConnectionHandler(Protocol):
    """A port for the events of one connection; :class:`Peer` fills it, and so does what is put around a peer."""

    @property
    def client_text(self) -> str:
        """Name of the client in the log."""
        ...

    def receive(self, data: bytes) -> None:
        """Bytes came from the client."""
        ...

    def writable(self) -> None:
        """The link is no longer choked."""
        ...

    def lost(self) -> None:
        """The link is gone."""
        ...

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients are told *reason*."""
        ...
