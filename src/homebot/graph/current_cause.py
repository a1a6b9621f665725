"""The cause of the current task's next command: a message, a change, a timer or a call.

Live queries, raw deliveries, timers and calls of clients set it before they call an application; commands read it. New
tasks inherit it.
"""

from contextvars import ContextVar
from dataclasses import dataclass
from typing import Final, final


@final
@dataclass(frozen=True, slots=True)
class TimerCause:
    """A due job of an app.

    Attributes:
        at: When it was due, in seconds since the Unix epoch.
    """

    id: str
    text: str
    at: float


@final
@dataclass(frozen=True, slots=True)
class CallCause:
    """A call of an app's service or action by a client of the door, which counts as a person's request.

    Attributes:
        issuer: The client, as ``client:NAME``.
    """

    issuer: str
    service: str
    at: float


CURRENT_CAUSE: Final[ContextVar[object]] = ContextVar("homebot.current_cause", default=None)
"""None for a task that acts on its own."""
