"""The cause of the current task's next command: a message, a change or a timer.

Live queries, raw deliveries and timers set it before they call an application; commands read it. New tasks inherit it.
"""

from __future__ import annotations

from contextvars import ContextVar
from typing import Final

__all__ = ["CURRENT_CAUSE"]

CURRENT_CAUSE: Final[ContextVar[object]] = ContextVar("homebot.current_cause", default=None)
"""None for a task that acts on its own."""
