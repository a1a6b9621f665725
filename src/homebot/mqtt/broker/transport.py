"""The port between a client's state machine and whatever carries its bytes."""

from __future__ import annotations

from typing import Protocol

__all__ = ["Transport"]


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
        """The far side in words, for the log."""
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
        """Send what was written, then close.

        Args:
            linger: The far side may still be sending: drain it for a moment, or the reason is lost.
        """
        ...
