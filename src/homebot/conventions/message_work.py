"""The work that all readers of one message share: thousands may read one topic, and a stranger announces as many."""

from collections.abc import Callable
from contextvars import ContextVar
from functools import partial
from typing import Final

__all__ = ["MOST_WORK", "begin_message", "work_left"]

MOST_WORK: Final = 30_000
"""Steps of all readers of a message, beside those that each has for itself; a step is about a microsecond."""

work_left: Final = ContextVar[int | None]("work_left", default=None)
"""The steps that are left for the message that this task reads; None if it reads none."""

begin_message: Final[Callable[[], object]] = partial(work_left.set, MOST_WORK)
"""Let the readers of the next message, in this task, have :data:`MOST_WORK` to share."""
