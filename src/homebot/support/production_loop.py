"""The event loop in production, which is watched, and which a stray ``sys.exit()`` does not stop.

A thread checks four times a second for how long the loop has been busy since it last polled, and reports the code that
blocks it. It does not touch the loop: it reads the stack of the loop's thread, as a debugger does. Times are on the
monotonic clock.
"""

import asyncio
import selectors
import sys
import sysconfig
import threading
import time
import traceback
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, Final, Protocol, Self, TypeVar, final

from anyio import to_thread

from homebot.support.logger import get_logger

BLOCKED = "runtime.loop_blocked"
FREE_AGAIN = "runtime.loop_free_again"
EXITED = "runtime.task_exited"

BLOCKED_AFTER = 1.0
AT_START = 10.0
"""The same until :meth:`LoopWatch.has_started`, while modules and files are loaded."""

_LOOK_EVERY = 0.25
_MAX_FRAMES = 20

_OURS: Final = str(Path(__file__).parents[1])
_LIBRARIES: Final = tuple(
    dict.fromkeys(sysconfig.get_paths()[name] for name in ("stdlib", "platstdlib", "purelib", "platlib"))
)

_log = get_logger(node="/homebot")


@final
class WatchedSelector(selectors.DefaultSelector):
    """A selector that tracks since when its event loop is busy.

    Attributes:
        busy_since: When it last had something ready, on the monotonic clock; None while the loop waits.
    """

    busy_since: float | None = None

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """Select."""
        self.busy_since = None
        try:
            return super().select(timeout)
        finally:
            self.busy_since = time.monotonic()


class BusyLoop(Protocol):
    """An object that tracks since when an event loop is busy, such as a :class:`WatchedSelector`."""

    busy_since: float | None


class LoopWatch:
    """The watch over an event loop: ``with LoopWatch(loop, selector) as watch``, in the thread of the loop.

    Attributes:
        blocked_after: Seconds after which one turn of the loop counts as blocked.
        longest: The longest blocked turn, in seconds.
        busy: Seconds of the present turn, without those due to an overloaded computer.
        exits: How often a task or callback outside homebot's isolation called ``sys.exit()``.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, selector: BusyLoop) -> None:
        self.blocks = 0
        self.longest = self.busy = 0.0
        self.last = ""
        self.exits = 0
        self.exited = ""
        self._exited_at = 0.0
        self._selector = selector
        self.blocked_after = AT_START
        self._last_at = 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="loop watch", daemon=True)
        self._loop = loop
        self._loop_thread = 0

    def has_started(self) -> None:
        """Use the shorter limit, as others wait for the loop from now on."""
        self.blocked_after = BLOCKED_AFTER

    def seconds_since_block(self) -> float:
        """Return the time since the loop was last blocked."""
        return time.monotonic() - self._last_at

    def seconds_since_exit(self) -> float:
        """Return the time since something last called ``sys.exit()``."""
        return time.monotonic() - self._exited_at

    def record_exit(self, error: SystemExit) -> None:
        """Count and log *error*, raised by a task or callback outside homebot's isolation."""
        self.exits += 1
        self._exited_at = time.monotonic()
        trace = traceback.extract_tb(error.__traceback__)
        where = f" in {trace[-1].filename}:{trace[-1].lineno} ({trace[-1].name})" if trace else ""
        self.exited = f"sys.exit({error.code!r}){where}"
        _log.error(
            EXITED, message=f"a task called {self.exited}; only that task ended, homebot continues", exc_info=error
        )

    def __enter__(self) -> Self:
        self._loop_thread = threading.get_ident()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join(BLOCKED_AFTER)

    def _watch(self) -> None:
        since: float | None = None  # the turn of the loop that was reported as blocked
        turn: float | None = None
        looked, used = time.monotonic(), time.process_time()
        while not self._stop.wait(_LOOK_EVERY):
            busy_since = self._selector.busy_since
            now, used_before = time.monotonic(), used
            used = time.process_time()
            if busy_since != turn:
                turn, self.busy, looked = busy_since, 0.0, busy_since or now
            self.busy += own_time(now - looked, used - used_before, _LOOK_EVERY)
            looked = now
            if since is not None:
                if busy_since == since:
                    self._record_block(now, now - since)
                else:
                    self._report_free(min(busy_since or now, now) - since)
                    since = None
            if since is None and busy_since is not None and self.busy >= self.blocked_after:
                stack = self._stack()
                if self._selector.busy_since == busy_since:  # otherwise the stack is of another turn
                    since = busy_since
                    self._report_blocked(now, now - busy_since, stack)
                del stack  # and with it everything that the frames refer to

    def _stack(self) -> list[FrameType]:
        """Return the frames of the loop's thread, innermost first."""
        frames: Mapping[int, FrameType] = sys._current_frames()  # noqa: SLF001 - public but for its name, as documented
        frame = frames.get(self._loop_thread)
        stack = []
        while frame is not None:
            stack.append(frame)
            frame = frame.f_back
        return stack

    def _report_blocked(self, now: float, seconds: float, stack: list[FrameType]) -> None:
        task = asyncio.current_task(self._loop)
        name = "a callback" if task is None else task.get_name()
        frame = next((frame for frame in stack if is_ours_or_the_users(frame)), stack[0] if stack else None)
        self.last = name if frame is None else f"{name} in {place_of_frame(frame)}"
        self.blocks += 1
        self._record_block(now, seconds)
        _log.error(
            BLOCKED,
            message=f"the event loop has been blocked for {seconds:.1f} s by {self.last}: nothing else can run; "
            "make it await, or run it in a thread",
            blocks=self.blocks,
            stack=[place_of_frame(frame) for frame in stack[:_MAX_FRAMES]],
        )

    def _record_block(self, now: float, seconds: float) -> None:
        self._last_at = now
        self.longest = max(self.longest, seconds)

    def _report_free(self, seconds: float) -> None:
        _log.warning(
            FREE_AGAIN,
            message=f"the event loop runs again; it was blocked for {seconds:.1f} s by {self.last}",
            seconds=round(seconds, 3),
        )


def own_time(elapsed: float, used: float, interval: float) -> float:
    """Return the seconds of *elapsed* between two checks without those due to an overloaded computer.

    A process that gets no processor checks late, and has used little processor time.

    Args:
        elapsed: Seconds since the last check.
        used: Processor time of the process since then, in seconds.
        interval: Seconds between two punctual checks.
    """
    return min(elapsed, max(interval, used))


def place_of_frame(frame: FrameType) -> str:
    """Return the file, line and function of *frame*."""
    return f"{frame.f_code.co_filename}:{frame.f_lineno} ({frame.f_code.co_name})"


def is_ours(frame: FrameType) -> bool:
    """Return whether *frame* is of homebot."""
    return frame.f_code.co_filename.startswith(_OURS)


def is_ours_or_the_users(frame: FrameType) -> bool:
    """Return whether *frame* is of no library."""
    return is_ours(frame) or not frame.f_code.co_filename.startswith((*_LIBRARIES, "<"))


T = TypeVar("T")


@final
class ProductionLoop(asyncio.SelectorEventLoop):
    """A selector loop on every platform, because the MQTT client needs ``add_reader``.

    In asyncio a SystemExit of any task stops the loop. Here it only ends that task, unless it is the main one.
    """

    def __init__(self) -> None:
        selector = WatchedSelector()
        super().__init__(selector)
        self.watch = LoopWatch(self, selector)
        self._main: asyncio.Future[Any] | None = None  # the loop's main task

    def run_until_complete(self, future: Awaitable[T]) -> T:  # type: ignore[override]  # typeshed knows two kinds of it
        """Run until *future* is done."""
        main = asyncio.ensure_future(future, loop=self)
        before, self._main = self._main, main
        try:
            return super().run_until_complete(main)
        finally:
            self._main = before

    def run_forever(self) -> None:
        """Run, recording a SystemExit of any task but the main one."""
        while True:
            try:
                super().run_forever()
            except SystemExit as exc:
                if self._main is None or (self._main.done() and self._main.exception() is exc):
                    raise
                self.watch.record_exit(exc)
                if self._main.done():
                    return
            else:
                return


async def load_beside_loop(load: Callable[[], T]) -> T:
    """Return the result of *load*, which loads modules, without letting others wait.

    On another loop than that of production it is loaded at once: nothing that happens there depends on a thread.
    """
    if isinstance(asyncio.get_running_loop(), ProductionLoop):
        return await to_thread.run_sync(load)
    return load()
