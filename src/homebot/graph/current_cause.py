"""The cause of the current task's next command: a message, a change or a timer.

Live queries, raw deliveries and timers set it before they call an application; commands read it. New tasks inherit it.
"""

from __future__ import annotations

from contextvars import ContextVar
from dataclasses import dataclass
from typing import Final, final

__all__ = ["CURRENT_CAUSE", "TimerCause"]


@final
@dataclass(frozen=True, slots=True)
class TimerCause:
    """A job of an app that was due.

    Attributes:
        text: When it is due, in words.
        at: When that was, in seconds since the Unix epoch.
    """

    id: str
    text: str
    at: float


CURRENT_CAUSE: Final[ContextVar[object]] = ContextVar("homebot.current_cause", default=None)
"""None for a task that acts on its own."""
