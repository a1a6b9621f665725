"""Requests that left this process without an answer: they may still have their effect, at any time.

A port marks the wait for an answer, and the server of commands asks whether one is missing when it gives up. So a
command that is still in a queue of homebot is told from one that waits in the network.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final, final

from homebot.errors import BusyError, PeerError

__all__ = ["SENT_REQUESTS", "SentRequests", "awaiting_answer"]


@final
class SentRequests:
    """The requests of one task.

    Attributes:
        is_unanswered: Whether the last one was sent, and not answered.
    """

    is_unanswered = False


SENT_REQUESTS: Final[ContextVar[SentRequests]] = ContextVar("homebot_sent_requests", default=SentRequests())  # noqa: B039 - nothing reads that of others
"""The requests of the current task, if its caller asks about them."""


@contextmanager
def awaiting_answer() -> Iterator[None]:
    """Send a request inside the block and wait for its answer; an error of the link, or a cancellation, is none."""
    requests = SENT_REQUESTS.get()
    requests.is_unanswered = True
    try:
        yield
    except (PeerError, BusyError):
        requests.is_unanswered = False
        raise
    requests.is_unanswered = False
