"""Requests that left this process without an answer: they may still have their effect, at any time.

A port marks the wait for an answer, and the server of commands asks whether one is missing when it gives up. So a
command that is still in a queue of homebot is told from one that waits in the network.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final, final

from homebot.errors import BusyError, PeerError

__all__ = ["SentRequests", "answered", "awaiting_answer", "sent", "watched_requests"]


@final
class SentRequests:
    """The requests of one task.

    Attributes:
        is_unanswered: Whether the last one was sent, and not answered.
    """

    __slots__ = ("is_unanswered",)

    def __init__(self) -> None:
        self.is_unanswered = False


_REQUESTS: Final[ContextVar[SentRequests | None]] = ContextVar("homebot_sent_requests", default=None)


@contextmanager
def watched_requests() -> Iterator[SentRequests]:
    """Watch the requests of the calling task, and of those that it starts, inside the block."""
    requests = SentRequests()
    token = _REQUESTS.set(requests)
    try:
        yield requests
    finally:
        _REQUESTS.reset(token)


@contextmanager
def awaiting_answer() -> Iterator[None]:
    """Send a request inside the block and wait for its answer; an error of the link, or a cancellation, is none."""
    sent()
    try:
        yield
    except (PeerError, BusyError):
        answered()
        raise
    answered()


def sent() -> None:
    """Mark that a request is being sent."""
    if (requests := _REQUESTS.get()) is not None:
        requests.is_unanswered = True


def answered() -> None:
    """Mark that its answer came."""
    if (requests := _REQUESTS.get()) is not None:
        requests.is_unanswered = False
