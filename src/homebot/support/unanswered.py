"""Requests sent without an answer, which may still take effect at any time.

A port marks the wait for an answer, and the server of commands checks whether one is missing when it gives up. This
distinguishes commands that never left homebot from those that wait in the network.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final, final

from homebot.errors import BusyError, PeerError


@final
class SentRequests:
    """The requests sent by one task.

    Attributes:
        is_unanswered: Whether the last one was sent but not answered.
    """

    is_unanswered = False


SENT_REQUESTS: Final[ContextVar[SentRequests]] = ContextVar("homebot_sent_requests", default=SentRequests())  # noqa: B039 - nothing reads that of others
"""The requests of the current task, if its caller wants to know."""


@contextmanager
def awaiting_answer() -> Iterator[None]:
    """Mark the block as sending a request and waiting for its answer, which fails by a LinkError or cancellation."""
    requests = SENT_REQUESTS.get()
    requests.is_unanswered = True
    try:
        yield
    except (PeerError, BusyError):
        requests.is_unanswered = False
        raise
    requests.is_unanswered = False
