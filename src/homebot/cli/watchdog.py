"""Ends a process that does not stop in time, whatever hangs in it."""

from __future__ import annotations

import os
import threading
from types import TracebackType
from typing import Self, final

from homebot.logger import get_logger

__all__ = ["Watchdog"]

LEFT_BEHIND = "runtime.left_behind"

WARN_AFTER = 4.5
EXIT_AFTER = 4.8
"""Seconds from :meth:`Watchdog.start` to the end of the process: together with a little work, below five."""

_log = get_logger(node="/homebot")


@final
class Watchdog:
    """``with Watchdog() as watchdog``: once started, it lets the block take 4.8 s more and then ends the process.

    It sits in threads of its own, so that neither an event loop that is blocked nor a terminal that takes no more text
    keeps the process alive.
    """

    def __init__(self) -> None:
        self._timers = (threading.Timer(WARN_AFTER, _warn), threading.Timer(EXIT_AFTER, os._exit, [1]))
        self._is_started = False
        self._lock = threading.RLock()  # reentrant, as a signal may come in the middle of a start

    def start(self) -> None:
        """Let the time run. Twice is fine, and so are a signal handler and any thread."""
        with self._lock:
            if self._is_started:
                return
            self._is_started = True
            for timer in self._timers:
                timer.daemon = True
                timer.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for timer in self._timers:
            timer.cancel()


def _warn() -> None:
    _log.critical(LEFT_BEHIND, message="not everything stopped in time; exiting anyway")
