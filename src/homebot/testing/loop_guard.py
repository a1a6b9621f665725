"""The watch over the event loop of a test, for code that blocks it."""

import asyncio
import signal
import time
from collections.abc import Iterable
from types import FrameType, SimpleNamespace, TracebackType
from typing import Any, Final, Self, final

from homebot.errors import UsageError
from homebot.support.production_loop import LoopWatch, is_ours, is_ours_or_the_users, place_of_frame

_SIGNAL: Final[Any] = getattr(signal, "SIGURG", None)  # the default is to ignore it, and no library uses it
_DEBUGGERS: Final = ("bdb", "pdb", "pydevd", "_pydevd", "debugpy")


@final
class LoopGuard(LoopWatch):
    """A watch over any loop: ``with LoopGuard(loop) as guard``, in its thread, before it runs.

    Args:
        ended_after: Seconds after which an error ends code that blocks the loop, where there are signals.

    Attributes:
        blocked_by: The places in apps that blocked the loop for a second.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, ended_after: float = 30.0) -> None:
        self.busy_since: float | None = None
        self.blocked_by: dict[str, None] = {}
        self._ended_after = ended_after
        self._ends: float | None = None  # the turn of the loop that is to end
        self._ended: float | None = None
        # Asyncio's own, and no public way to it; another kind of loop is not watched.
        self._selector_of_loop: Any = getattr(loop, "_selector", SimpleNamespace(select=None))
        self._handler: Any = None
        super().__init__(loop, self)
        self.has_started()

    def __enter__(self) -> Self:
        select = self._selector_of_loop.select

        def tracked(timeout: float | None = None) -> object:
            self.busy_since = None
            try:
                return select(timeout)
            finally:
                self.busy_since = time.monotonic()

        self._selector_of_loop.select = tracked
        try:
            self._handler = _SIGNAL and signal.signal(_SIGNAL, self._end)
        except ValueError:  # not the main thread
            self._handler = None
        return super().__enter__()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        super().__exit__(kind, error, trace)
        del self._selector_of_loop.select
        if self._handler is not None:
            signal.signal(_SIGNAL, self._handler)

    def _report_blocked(self, now: float, seconds: float, stack: list[FrameType]) -> None:
        place, is_of_app = _user_place(stack)
        if is_of_app:
            self.blocked_by[place] = None
        self._record_block(now, seconds)

    def _report_free(self, seconds: float) -> None:
        """Leave it to the end of the test."""

    def _record_block(self, now: float, seconds: float) -> None:
        super()._record_block(now, seconds)
        if self._handler is not None and self.busy >= self._ended_after and _user_place(self._stack())[0]:
            self._ended_after = self.blocked_after  # it may be called again
            self._ends = self.busy_since
            signal.pthread_kill(self._loop_thread, _SIGNAL)

    def _end(self, _: int, frame: FrameType | None) -> None:
        if frame is not None and self._ends is not None and self._ends == self.busy_since:
            kind = SystemExit if self._ends == self._ended else UsageError  # the code caught the first
            self._ended = self._ends
            raise kind(f"{place_of_frame(frame)} has blocked the event loop: nothing else can run; make it await")


def _user_place(stack: Iterable[FrameType]) -> tuple[str, bool]:
    """Return the innermost place of a test or app on the *stack* of a running loop, and whether homebot called it.

    It is empty if there is none, or in a debugger.
    """
    place = ""
    for frame in stack:
        if frame.f_globals.get("__name__", "").startswith(_DEBUGGERS):
            break
        if frame.f_code.co_name == "run_forever":
            return place, False
        if is_ours(frame) and place:
            return place, True
        if not is_ours(frame) and is_ours_or_the_users(frame):
            place = place or place_of_frame(frame)
    return "", False
