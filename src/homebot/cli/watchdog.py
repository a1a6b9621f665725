"""Ends a process that does not stop in time, even if something in it hangs."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self, final

from homebot.support.logger import get_logger
from homebot.support.production_loop import own_time

__all__ = ["Watchdog"]

LEFT_BEHIND = "runtime.left_behind"

WARN_AFTER = 4.5
EXIT_AFTER = 4.8
"""Seconds from :meth:`Watchdog.start` to the end of the process: together with a little work, below five.

Those do not count in which the process got no processor, as the computer slept or was too busy.
"""

_LOOK_EVERY = 0.1

_log = get_logger(node="/homebot")


@final
class Watchdog:
    """``with Watchdog() as watchdog``: once started, it lets the block take 4.8 s more and then ends the process.

    It sits in threads of its own, so that neither an event loop that is blocked nor a terminal that takes no more text
    keeps the process alive.
    """

    def __init__(self) -> None:
        self._over = threading.Event()
        actions = ((WARN_AFTER, _warn), (EXIT_AFTER, _exit))
        self._threads = [threading.Thread(target=self._run, args=one, name="watchdog", daemon=True) for one in actions]
        self._is_started = False
        self._lock = threading.RLock()  # reentrant, as a signal may come in the middle of a start

    def start(self) -> None:
        """Let the time run. Twice is fine, and so are a signal handler and any thread."""
        with self._lock:
            if self._is_started:
                return
            self._is_started = True
            for thread in self._threads:
                thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()

    def _run(self, seconds: float, act: Callable[[], None]) -> None:
        left, looked, used = seconds, time.monotonic(), time.process_time()
        while left > 0:
            wait = min(left, _LOOK_EVERY)
            if self._over.wait(wait):
                return
            before, looked = looked, time.monotonic()
            used_before, used = used, time.process_time()
            left -= own_time(looked - before, used - used_before, wait)
        act()


def _warn() -> None:
    _log.critical(LEFT_BEHIND, message="not everything stopped in time; exiting anyway")


def _exit() -> None:
    os._exit(1)
