"""The runs of one handler of an app, with the rule for a call while an earlier one is still running."""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Coroutine
from inspect import isawaitable, signature
from typing import Final, Literal, TypeAlias, final, get_args

import anyio

from homebot.errors import UsageError
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.log import LogLimit, more_like_this
from homebot.support.isolation import crash_of, error_text, is_end_of, uncancel
from homebot.support.names import did_you_mean

CALL_DROPPED: Final = "app.call_dropped"
FAILURES_IN_A_ROW: Final = 5
"""Consecutive failures after which a handler is not called any more."""
MAX_RUNS: Final = 10
_QUIET: Final = 600.0  # seconds between two lines about dropped calls of a handler

RunMode: TypeAlias = Literal["single", "restart", "queued", "parallel"]
RunHandler: TypeAlias = Callable[[], Awaitable[object] | None]
StartTask: TypeAlias = Callable[[Callable[[], Coroutine[object, object, object]]], object]


def check_handler(handler: object, *arguments: object) -> None:
    """Refuse a *handler* that cannot be called with as many arguments as *arguments*, which are values or names.

    Raises:
        UsageError: It is not a function, or takes other arguments.
    """
    if not callable(handler):
        raise UsageError(f"handler: {handler!r:.60} is not a function; give it without parentheses, like self.turn_off")
    try:
        signature(handler).bind(*arguments)
    except TypeError as exc:
        takes = ", ".join(f"{argument!s:.60}" for argument in arguments) or "no argument"
        raise UsageError(f"handler: {getattr(handler, '__name__', handler)} is called with {takes}: {exc}") from exc
    except ValueError:  # a C function without a signature
        return


@final
class HandlerRuns:
    """The runs of one handler, each a task of its app.

    A failure costs only its run: it is logged, counted in ``graph.failures`` and shown by ``homebot doctor``. After
    five in a row the handler is given up.

    Args:
        title: Name of the handler in the log and in health reports, such as ``job evening``.
        mode: The rule for a call while an earlier one runs: ``single`` drops it, ``restart`` cancels the earlier one,
            ``queued`` waits for its turn, ``parallel`` runs concurrently.
        most: The limit of running and waiting calls, at which ``queued`` and ``parallel`` drop the next.
        is_quiet: Whether dropped calls are normal, and logged only at level debug.

    Attributes:
        title: As above.
        trouble: Why the handler is not called any more; empty while it is called.

    Raises:
        UsageError: There is no such mode, or *most* is below 1.
    """

    def __init__(
        self,
        node: Node,
        start_task: StartTask,
        title: str,
        mode: RunMode = "single",
        most: int = MAX_RUNS,
        *,
        is_quiet: bool = False,
    ) -> None:
        if mode not in (modes := get_args(RunMode)):
            hint = did_you_mean(str(mode), modes, f"modes are {', '.join(modes)}")
            raise UsageError(f"mode: there is no {mode!r}; {hint}")
        if type(most) is not int or most < 1:
            raise UsageError(f"most: {most!r} is not a number from 1 on")
        self.dropped = self.failures = 0
        self.trouble = ""
        self._node = node
        self._start_task = start_task
        self.title = title
        self._mode = mode
        self._is_quiet = is_quiet
        self._most = most if mode in ("queued", "parallel") else 1
        self._tasks_at_once = most if mode == "parallel" else 1
        self._tasks = 0
        self._waiting: deque[tuple[RunHandler, object]] = deque()
        self._running: dict[anyio.CancelScope, float] = {}  # start of each, in seconds since the Unix epoch
        self._limit = LogLimit(node.graph.clock, _QUIET)

    @property
    def running_since(self) -> float | None:
        """Start of the oldest run, in seconds since the Unix epoch; None if there is none."""
        return next(iter(self._running.values()), None)

    def start(self, handler: RunHandler, cause: object = None) -> bool:
        """Call *handler* according to the mode; return False if it is not called.

        Args:
            cause: The cause of its commands, see :data:`homebot.graph.current_cause.CURRENT_CAUSE`.
        """
        if self.trouble:
            return False
        if self._mode == "restart":
            self._waiting.clear()
            for scope in self._running:
                scope.cancel()
        elif len(self._running) + len(self._waiting) >= self._most:
            self.dropped += 1
            if (held_back := self._limit.allows("")) is not None:
                why = "its last call still runs" if self._most == 1 else f"{self._most} calls run or wait"
                log = self._node.log.debug if self._is_quiet else self._node.log.warning
                log(
                    CALL_DROPPED,
                    message=f"the {self.title} was not called: {why}{more_like_this(held_back)}",
                    mode=self._mode,
                    dropped=self.dropped,
                )
            return False
        self._waiting.append((handler, cause))
        if self._tasks < self._tasks_at_once:
            self._tasks += 1
            self._start_task(self._work)
        return True

    def cancel(self) -> None:
        """Cancel the running and waiting calls."""
        self._waiting.clear()
        for scope in self._running:
            scope.cancel()

    async def _work(self) -> None:
        try:
            while self._waiting and not self.trouble:
                await self._run(*self._waiting.popleft())
        finally:
            self._tasks -= 1

    async def _run(self, handler: RunHandler, cause: object) -> None:
        CURRENT_CAUSE.set(cause)
        with anyio.CancelScope() as scope:
            self._running[scope] = self._node.graph.clock.now()
            task = asyncio.current_task()
            try:
                if isawaitable(result := handler()):
                    await result
                self.failures = 0
            except BaseException as exc:  # every failure but the end of this run
                if is_end_of(task, exc):
                    raise
                self._record(exc)
            finally:
                del self._running[scope]

    def _record(self, error: BaseException) -> None:
        if isinstance(error, asyncio.CancelledError):
            uncancel()
        crash = crash_of(self._node.full_name, error)
        self.failures += 1
        cost = f"it is called again, up to {FAILURES_IN_A_ROW} failures in a row"
        if self.failures >= FAILURES_IN_A_ROW:
            self._waiting.clear()
            cost = f"it was the {self.failures}th time in a row, and it is not called until the app is restarted"
            self.trouble = f"failed {self.failures} times in a row and is not called any more ({error_text(crash)})"
        self._node.graph.failures.record(self._node.full_name, self.title, crash, cost)
