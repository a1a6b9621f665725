"""An event loop with virtual time: whenever nothing is ready, the next timer is due at once.

An hour of timers passes in milliseconds, every timer fires at exactly its time, and nothing depends on the speed of the
computer. No time passes while a worker thread of ``anyio.to_thread`` or of the loop's executor works, so that a slow
disk takes no virtual time; threads with their own limiter, such as permanent ones, are not waited for. Do not use real
sockets on this loop: it does not wait for them while a timer is set.
"""

import asyncio
import math
import selectors
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from contextvars import Context
from pathlib import Path
from typing import NamedTuple, TypeVar, TypeVarTuple

import anyio
from anyio import to_thread

from homebot.errors import UsageError
from homebot.support.isolation import frames_of

Ts = TypeVarTuple("Ts")
ResultT = TypeVar("ResultT")

RESOLUTION = 1e-6  # seconds; timers closer than this fire together. Far above the steps of a float at 30 years
SELDOM = 50  # turns of a busy loop after which files are checked nevertheless
_LIBRARIES = tuple(str(Path(str(library.__file__)).parent) for library in (asyncio, anyio))


class LoopLimits(NamedTuple):
    """LoopLimits of programs in virtual time, in real seconds.

    Attributes:
        hot_after: Seconds without passing virtual time after which, with
        hot_turns: turns of the loop, a program counts as busy forever.
        stuck_after: Seconds for a thread or a signal to wake a loop without timers.
        thread_stuck_after: Seconds allowed for a worker thread, which may write to a slow disk.
    """

    hot_after: float = 30.0
    hot_turns: int = 500_000
    stuck_after: float = 30.0
    thread_stuck_after: float = 120.0


LOOP_LIMITS = LoopLimits()


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop in virtual time, which starts at 0.

    For ``asyncio.Runner(loop_factory=VirtualTimeLoop)`` and similar. A program that waits for an impossible event, with
    nothing ready and no timer set, ends with :class:`homebot.errors.UsageError` after 30 real seconds; one that is
    always busy, so that no time can pass, after 30 seconds and half a million turns. The error names the busy tasks. A
    worker thread that takes longer than 120 real seconds ends it too.
    """

    def __init__(self, limits: LoopLimits = LOOP_LIMITS) -> None:
        self._limiter: anyio.CapacityLimiter | None = None
        self._executing = 0
        self._jumping = _JumpingSelector(self._busy, self._threads_at_work, limits)
        super().__init__(self._jumping)
        self._clock_resolution = (
            RESOLUTION  # asyncio's default vanishes in the float after 97 days, and timers would never be due
        )

    def time(self) -> float:
        """Return the seconds of virtual time since the loop was created."""
        return self._jumping.now

    def run_in_executor(
        self, executor: Executor | None, func: Callable[[*Ts], ResultT], *args: *Ts
    ) -> asyncio.Future[ResultT]:
        """Run *func* in a thread; no time passes until it is done."""
        future = super().run_in_executor(executor, func, *args)
        self._executing += 1
        future.add_done_callback(self._execute)
        return future

    async def settled(self) -> None:
        """Wait until everything due has happened, in worker threads too, without passing time."""
        waiter: asyncio.Future[None] = self.create_future()
        self._jumping.waiters.append(waiter)
        await waiter

    def call_at(
        self,
        when: float,
        callback: Callable[[*Ts], object],
        *args: *Ts,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Call *callback* at *when*; a timer at infinity, as in ``anyio.sleep_forever``, does not count."""
        if when == math.inf:
            return asyncio.TimerHandle(when, callback, args, self, context)
        return super().call_at(when, callback, *args, context=context)

    async def _find_limiter(self) -> None:
        self._limiter = to_thread.current_default_thread_limiter()  # only a task may ask for it

    def _execute(self, _: asyncio.Future[ResultT]) -> None:
        self._executing -= 1

    def _threads_at_work(self) -> int | None:
        """Return the number of busy worker threads, or None in the first turn that could pass time."""
        if self._limiter is None:
            self.create_task(self._find_limiter(), name="limiter of worker threads")
            return None
        return self._executing + self._limiter.borrowed_tokens

    def _busy(self) -> str:
        """Return the tasks of this turn, and their places."""
        handles: Iterable[asyncio.Handle] = getattr(self, "_ready", ())  # asyncio's own, and no public way to it
        owners = (getattr(getattr(handle, "_callback", None), "__self__", None) for handle in handles)
        places = {f"{task.get_name()} in {_place(task)}" for task in owners if isinstance(task, asyncio.Task)}
        return ", ".join(sorted(places)) or "no task"


def _place(task: asyncio.Task[object]) -> str:
    """Return the place where *task* waits: its innermost coroutine outside asyncio and anyio."""
    frames = frames_of(task.get_coro())
    own = [frame for frame in frames if not frame.f_code.co_filename.startswith(_LIBRARIES)]
    for frame in (own or frames)[-1:]:
        return f"{frame.f_code.co_qualname}, {frame.f_code.co_filename}:{frame.f_lineno}"
    return "its end"


class _JumpingSelector(selectors.DefaultSelector):
    """A selector that passes virtual time instead of waiting."""

    now = 0.0

    def __init__(self, busy: Callable[[], str], threads_at_work: Callable[[], int | None], limits: LoopLimits) -> None:
        super().__init__()
        self.waiters: deque[asyncio.Future[None]] = deque()
        self._busy = busy
        self._threads_at_work = threads_at_work
        self._limits = limits
        self._unasked = 0
        self._turns = 0
        self._busy_since = time.monotonic()

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout != 0 and (threads := self._threads_at_work()) != 0:
            return self._select_thread() if threads else []
        if timeout is None and not self.waiters:
            return self._select_or_give_up()
        if timeout == 0 and self._unasked < SELDOM:  # there is work: the system call would double its cost
            self._unasked += 1
            return []
        self._unasked = 0
        ready = super().select(0)
        if timeout == 0 or ready:
            self._end_if_hot()
            return ready
        self._turns = 0
        if self.waiters:
            while self.waiters:
                waiter = self.waiters.popleft()
                if not waiter.done():
                    waiter.set_result(None)
        elif timeout is not None:
            self.now += timeout
        return ready

    def _end_if_hot(self) -> None:
        """Count another :data:`SELDOM` turns in which no time passed."""
        if self._turns == 0:
            self._busy_since = time.monotonic()
        self._turns += SELDOM
        if self._turns >= self._limits.hot_turns and time.monotonic() - self._busy_since >= self._limits.hot_after:
            raise UsageError(
                f"virtual time cannot advance: something is always busy and never waits; now: {self._busy()}"
            )

    def _select_thread(self) -> list[tuple[selectors.SelectorKey, int]]:
        longest = self._limits.thread_stuck_after
        ready = super().select(longest)
        if not ready:
            raise UsageError(
                f"virtual time cannot advance: a worker thread has worked for {longest:.0f} real seconds; "
                "give one that runs for good a limiter of its own"
            )
        return ready

    def _select_or_give_up(self) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(self._limits.stuck_after)
        if not ready:
            raise UsageError("nothing is ready and no timer is set: the program waits for an event that cannot happen")
        return ready
