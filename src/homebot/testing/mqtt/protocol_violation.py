"""Violations of MQTT by clients."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import final

from homebot.mqtt.packets import PacketError, ReasonCode

__all__ = ["ProtocolViolation", "ViolationLog"]

_MAX_KEPT = 20
_NO_BREACH = (
    ReasonCode.KEEP_ALIVE_TIMEOUT,  # silence may be a test's purpose
    ReasonCode.UNSUPPORTED_PROTOCOL_VERSION,  # clients try the newest first
    ReasonCode.BAD_AUTHENTICATION_METHOD,  # allowed, but not offered here
)


@dataclass(frozen=True, slots=True)
class ProtocolViolation:
    """One connection that the broker closed because its client broke the protocol.

    Attributes:
        client: Client id, or the address before the login.
        reason: The reason code the connection was closed with.
        problem: What was wrong, for people.
    """

    client: str
    reason: ReasonCode
    problem: str

    def __str__(self) -> str:
        return f"client {self.client!r} broke the protocol: {self.problem} (0x{self.reason:02x}, {self.reason.words})"


@final
class ViolationLog:
    """The first 20 breaches that nobody has taken; written on the broker's thread, read in any.

    Attributes:
        untold: How many more there were.
    """

    def __init__(self) -> None:
        self.untold = 0
        self._kept: deque[ProtocolViolation] = deque()

    @property
    def kept(self) -> tuple[ProtocolViolation, ...]:
        """In their order."""
        return tuple(self._kept.copy())

    def record(self, client: str, error: PacketError) -> None:
        """Note why a connection was closed, where that is a breach."""
        if error.code in _NO_BREACH:
            return
        if len(self._kept) == _MAX_KEPT:
            self.untold += 1
        else:
            self._kept.append(ProtocolViolation(client, error.code, error.problem))

    def clear(self) -> None:
        """Forget them, those that were not kept too."""
        self._kept.clear()
        self.untold = 0
