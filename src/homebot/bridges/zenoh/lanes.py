"""Lanes to the peers of a session: calls that block while a peer does not read, away from the event loop.

The calls of one peer are made in order; those of different peers side by side, so a peer that hangs holds up itself
alone. Zenoh gives up a peer after five seconds.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Hashable
from typing import Final

from homebot.support.isolation import error_text

MAX_LANES: Final = 64
"""Peers for which calls wait at a time, each with a thread."""

MAX_WAITING: Final = 200
MAX_WAITING_BYTES: Final = 16_777_216
"""Calls that wait for one peer, and bytes in them."""


class Lanes:
    """Threads that make calls, each for as long as a peer has some.

    Args:
        on_panic: Called in such a thread after a panic inside Zenoh, whose locks are of no use from then on.

    Attributes:
        working: Held by a call while it works for long without waiting: the event loop competes with one at a time.
        refused: Calls that were not made because too many waited.
        failed: Calls that ended with an exception.
        problem: That of the last one; empty if there is none.
    """

    def __init__(self, on_panic: Callable[[], None]) -> None:
        self._on_panic = on_panic
        self.working = threading.Lock()
        self._lock = threading.Lock()
        self._waiting: dict[Hashable, deque[tuple[Callable[[], object], int]]] = {}
        self._is_closed = False
        self.refused = 0
        self.failed = 0
        self.problem = ""

    def make(
        self, peer: Hashable, call: Callable[[], object], size: int, instead: Callable[[], object] | None = None
    ) -> bool:
        """Make *call* with *size* bytes, which raises nothing, after the earlier ones of *peer*.

        Args:
            instead: A call without data that is made in its place if too many wait.

        Returns:
            False if *call* is not made.
        """
        with self._lock:
            if self._is_closed:
                return False
            waiting = self._waiting.get(peer)
            is_new = waiting is None
            if waiting is None:
                is_full = len(self._waiting) >= MAX_LANES
            else:
                is_full = len(waiting) >= MAX_WAITING or sum(taken for _, taken in waiting) >= MAX_WAITING_BYTES
            if is_full:
                self.refused += 1
                if instead is None:
                    return False
                call, size = instead, 0
            if waiting is None:
                waiting = self._waiting[peer] = deque()
            waiting.append((call, size))
        if is_new:
            threading.Thread(target=self._run, args=(peer, waiting), daemon=True, name="zenoh lane").start()
        return not is_full

    def close(self) -> None:
        """Make no further call, as those on a session that closes may panic."""
        with self._lock:
            self._is_closed = True
            for waiting in self._waiting.values():
                waiting.clear()

    def _run(self, peer: Hashable, waiting: deque[tuple[Callable[[], object], int]]) -> None:
        while True:
            with self._lock:
                if not waiting:
                    del self._waiting[peer]
                    return
                call, _ = waiting.popleft()
            try:
                call()
            except BaseException as exc:  # noqa: BLE001 - a panic inside Zenoh is one, and the calls after it wait
                self.failed += 1
                self.problem = error_text(exc)
                if not isinstance(exc, Exception):
                    self._on_panic()
            del call  # and its data
