"""The timing of the keep-alive: when to ping a silent broker, and when to consider it dead. No I/O."""

from enum import Enum
from typing import final


class LifeSign(Enum):
    """The next step of the keep-alive."""

    WAIT = "wait"
    PING = "ping"
    LOST = "lost"


@final
class KeepAlive:
    """The keep-alive of one link, on the client's side.

    It pings once per interval, and after an interval of silence. An answer, or anything else, must come within the
    time-out or half an interval, whichever is shorter, so that a dead link is noticed after one and a half intervals at
    most.

    Args:
        interval: The keep-alive interval in seconds.
        timeout: The longest wait for an answer, in seconds.
        now: The time on the monotonic clock.

    Attributes:
        heard_at: Time of the last received bytes, set by the reader.
    """

    def __init__(self, interval: float, timeout: float, now: float) -> None:
        self._interval = interval
        self._patience = min(timeout, interval / 2)
        self.heard_at = self._pinged_at = now
        self._waiting = False
        self.due = now + interval

    def check(self, now: float) -> LifeSign:
        """Return the action due now; a ping counts as sent."""
        self._waiting = self._waiting and self.heard_at < self._pinged_at
        if self._waiting:
            self.due = self._pinged_at + self._patience
            return LifeSign.LOST if self.due <= now else LifeSign.WAIT
        self.due = min(self.heard_at, self._pinged_at) + self._interval
        if self.due > now:
            return LifeSign.WAIT
        self._pinged_at = now
        self._waiting = True
        self.due = now + self._patience
        return LifeSign.PING
