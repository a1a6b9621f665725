"""Gives memory back to the system after much of it was in use for a while."""

from __future__ import annotations

from homebot.gateways.announced.scheduler import Scheduler
from homebot.memory_trim import MemoryTrimmer

__all__ = ["LONG", "SpareMemory"]

LONG = 32 * 1024
"""Bytes of a message from which on reading it leaves holes in the heap that are worth a look."""

_AFTER = 10.0
"""Seconds within which the directory and the broker, too, have freed removed announcements."""


class SpareMemory:
    """Looks ten seconds after something was freed whether there is something to give back.

    Args:
        scheduler: Keeps the time.
    """

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._trimmer = MemoryTrimmer()
        self._looks = 0
        self._is_planned = False

    def freed(self) -> None:
        """Plan a look for something that was freed, once for all that is freed until then."""
        if not self._is_planned:
            self._is_planned = self._scheduler.plan(("memory",), _AFTER, self._look)

    def _look(self) -> None:
        self._is_planned = False
        self._looks += 1
        self._trimmer.trim_if_worthwhile(self._looks)
