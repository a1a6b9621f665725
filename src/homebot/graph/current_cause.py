"""The message, or the timer, that a task acts upon now: the cause of the command that it gives next.

Whoever hands something to an application sets it: a live query, a raw message, a timer. Setting it makes nothing; a
command reads it. A task that is started inherits it, as all context variables.
"""

from __future__ import annotations

from contextvars import ContextVar
from typing import Final

__all__ = ["CURRENT_CAUSE"]

CURRENT_CAUSE: Final[ContextVar[object]] = ContextVar("homebot.current_cause", default=None)
"""None where the task acts of its own accord."""
