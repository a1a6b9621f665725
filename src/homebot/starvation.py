"""Time in which the computer let a thread do nothing: it must not be taken for work that takes long."""

from __future__ import annotations

from pathlib import Path
from typing import final

__all__ = ["StarvedTime", "queued_seconds"]


@final
class StarvedTime:
    """Adds up the time in which neither the process nor, on Linux, one thread of it got a processor.

    Args:
        interval: Seconds between two looks, if nothing is late.

    Attributes:
        seconds: The sum; set it to 0 to begin anew.
    """

    def __init__(self, interval: float) -> None:
        self.seconds = 0.0
        self._interval = interval
        self._last: tuple[float, float, float] | None = None

    def look(self, now: float, used: float, queued: float) -> None:
        """Add the time since the last look.

        Args:
            now: Reading of the monotonic clock, in seconds.
            used: Seconds of the processor that the process used so far.
            queued: Seconds for which the thread waited for a processor so far; see :func:`queued_seconds`.
        """
        if self._last is not None:
            before, used_before, queued_before = self._last
            late = now - before - max(self._interval, used - used_before)  # it works while the looks pause
            self.seconds += max(0.0, late, queued - queued_before)
        self._last = now, used, queued


def queued_seconds(native_id: int) -> float:
    """Return for how many seconds a thread of this process waited for a processor so far; 0 where nobody counts them.

    Source: Linux, Documentation/scheduler/sched-stats.rst, /proc/<pid>/schedstat.
    """
    try:
        return int(Path(f"/proc/self/task/{native_id}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    except (OSError, IndexError):
        return 0.0
