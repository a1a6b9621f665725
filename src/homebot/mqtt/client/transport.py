"""The port between the state machine of a client and its transport."""

from collections.abc import Awaitable, Callable
from typing import Final, Protocol, TypeAlias

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.options import MqttOptions

SEND_BUFFER: Final = 256 * 1024
"""Bytes waiting for the broker from which a publish of QoS 0 waits too."""


class TransportUser(Protocol):
    """The client as the user of a transport."""

    def data_received(self, data: bytes) -> None:
        """Handle bytes from the broker."""

    def drained(self) -> None:
        """Continue writing: few or no bytes wait for the broker."""

    def link_ended(self, reason: LinkError | RefusedError) -> None:
        """End after the link was closed by the broker or broke."""


class ClientTransport(Protocol):
    """The client's end of one link: bytes in order, both ways."""

    @property
    def waiting(self) -> int:
        """Written bytes that the broker has not read yet."""

    def write(self, data: bytes) -> None:
        """Send *data*; ignored after a close."""

    def write_acknowledgements(self, data: bytes) -> None:
        """Send *data* together with the next data, or alone a moment later."""

    def close(self) -> None:
        """Close after sending all written data; nothing more is received."""

    async def wait_closed(self) -> None:
        """Wait for the end of a close; after a second the link is cut."""

    def abort(self) -> None:
        """Cut the link: unread data is lost, and nothing more is received."""


Dial: TypeAlias = Callable[[MqttOptions, TransportUser], Awaitable[ClientTransport]]
"""Opens a link to the broker in the options; its bytes go to the user.

It raises LinkError if no answer comes in time, RefusedError if the certificate of one side is not trusted by the other,
and UsageError if a certificate file cannot be used.
"""
