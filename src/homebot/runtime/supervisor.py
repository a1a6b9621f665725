"""Keeps components running: a crashed one is restarted without affecting the others.

Each start of a component has its own task. A crash is logged, with a traceback if it differs from the previous crash,
and followed by a restart, after a delay that grows with each crash within a minute; a component that crashes five times
within a minute is given up, for an hour or until it is restarted by hand; an app for good. SystemExit, GeneratorExit
and a cancellation that the component itself caused are crashes like any other. A UsageError at the first start is not a
crash but a mistake of the user, and ends the start of homebot.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, nullcontext
from dataclasses import dataclass, field
from typing import Literal, Protocol

import anyio
from anyio.abc import TaskStatus

from homebot.clock import Clock
from homebot.errors import UsageError
from homebot.support.isolation import Place, error_text, first_cause, is_cancelled, place_of, run_as
from homebot.support.logger import get_logger

CRASHED = "runtime.crashed"
ENDED = "runtime.ended"
GIVEN_UP = "runtime.given_up"
NOT_READY = "runtime.not_ready"
RESTARTED = "runtime.restarted"

FIRST_DELAY = 0.5
MAX_CRASHES = 5
CRASH_WINDOW = 60.0
READY_WITHIN = 10.0
RETRY_AFTER = 3600.0
"""Seconds after which a component that was given up is tried again."""

_log = get_logger(node="/homebot")


class Work(Protocol):
    """The work of a component until it is cancelled or done; it reports when it is ready."""

    def __call__(self, *, task_status: TaskStatus[None]) -> Awaitable[None]:
        """Run; an exception is a crash, returning is the normal end."""


@dataclass(slots=True)
class ComponentCrashes:
    """The previous crashes of a component.

    Attributes:
        at: The time of the last crash, in seconds since the Unix epoch.
    """

    count: int = 0
    last: str = ""
    at: float = 0.0
    state: Literal["restarting", "running again", "ended", "given up", "stopped"] = "restarting"


class Supervisor:
    """Starts, restarts and gives up components."""

    def __init__(self, clock: Clock) -> None:
        self.crashes: dict[str, ComponentCrashes] = {}
        self.restarts: dict[str, int] = {}
        self.given_up: list[str] = []
        self._clock = clock
        self._titles: dict[str, str] = {}
        self._shown: dict[str, Place] = {}  # where the crash was whose traceback was last shown
        self._runs: dict[str, anyio.CancelScope] = {}
        self._awaited: set[_Start] = set()
        self._is_hurried = False

    def hurry(self) -> None:
        """Stop waiting for components to become ready."""
        self._is_hurried = True
        for start in self._awaited:
            start.stop_waiting()

    @asynccontextmanager
    async def running(
        self,
        name: str,
        work: Work,
        title: str = "",
        *,
        retry_after: float = RETRY_AFTER,
        down: Callable[[str], AbstractAsyncContextManager[object]] = nullcontext,
    ) -> AsyncIterator[None]:
        """Keep *work* running inside the block; entering waits until it is ready, leaving until it has ended.

        After 10 s it no longer waits for the component to become ready.

        Args:
            name: Its own name: that of its node, or one that no node can have.
            title: Its name in the log; by default *name*.
            retry_after: Seconds after which it is tried again once it is given up; infinite for never.
            down: Entered with the reason while it waits for its restart.

        Raises:
            UsageError: The component cannot be started as configured.
        """
        start = _Start()
        self._log_state(name, "running again")
        self._titles[name] = title or name
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._supervise, _Component(name, work, start, retry_after, down))
            await self._wait_for(name, start)
            if start.mistake is None:
                yield
            tasks.cancel_scope.cancel()
        if start.mistake is not None:
            raise start.mistake

    def restart(self, name: str) -> None:
        """Stop a component and start it at once, also one that was given up; an unknown name is ignored."""
        if (run := self._runs.get(name)) is not None:
            run.cancel()

    def forget(self, name: str) -> None:
        """Forget the crashes of a component that is no longer running."""
        for known in (self.crashes, self.restarts, self._titles, self._shown):
            known.pop(name, None)
        if name in self.given_up:
            self.given_up.remove(name)

    async def _wait_for(self, name: str, start: _Start) -> None:
        if self._is_hurried:
            return
        self._awaited.add(start)
        try:
            with anyio.move_on_after(READY_WITHIN):
                await start.wait()
        finally:
            self._awaited.discard(start)
        title = self._titles[name]
        if not start.is_over and not self._is_hurried:
            _log.warning(
                NOT_READY,
                message=f"{title} is not ready after {READY_WITHIN:g} s; homebot continues without waiting for it",
                component=name,
            )

    async def _supervise(self, component: _Component) -> None:
        name = component.name
        try:
            while True:
                is_over = False
                with anyio.CancelScope() as restart:
                    self._runs[name] = restart
                    is_over = await self._run_and_pause(component)
                if restart.cancel_called:
                    component.recent.clear()
                    _log.info(RESTARTED, message=f"{self._titles[name]} is restarted by hand", component=name)
                elif is_over:
                    return
                self.restarts[name] = self.restarts.get(name, 0) + 1
                self._log_state(name, "running again")
        finally:
            self._runs.pop(name, None)

    async def _run_and_pause(self, component: _Component) -> bool:
        """Run a component, and wait until it is to run again; return whether it is over."""
        name, start, recent = component.name, component.start, component.recent
        crash = await self._run_once(name, component.work, start)
        if crash is None:
            _log.info(ENDED, message=f"{self._titles[name]} ended", component=name)
            self._log_state(name, "ended")
            start.started()
            return True
        cause = first_cause(crash)
        if isinstance(cause, UsageError) and not start.is_over:
            start.mistake = cause
            start.started()
            return True
        now = self._clock.monotonic()
        while recent and now - recent[0] >= CRASH_WINDOW:
            recent.popleft()
        recent.append(now)
        is_given_up = len(recent) >= MAX_CRASHES
        delay = component.retry_after if is_given_up else FIRST_DELAY * 2.0 ** (len(recent) - 1)
        self._report(name, cause, delay, is_given_up=is_given_up)
        start.started()  # better to start homebot without it than not at all
        if delay == math.inf:
            return True
        async with component.down(f"it crashed ({error_text(cause)}) and starts again in {_time_text(delay)}"):
            await anyio.sleep(delay)
        if is_given_up:
            recent.clear()
        return False

    async def _run_once(self, name: str, work: Work, start: _Start) -> Exception | None:
        """Run *work* in its own task, which it may cancel; return its crash, or None."""
        crash: Exception | None = None

        async def run() -> None:
            nonlocal crash
            try:
                await run_as(name, lambda: work(task_status=start))
            except Exception as exc:  # noqa: BLE001 - a supervisor handles every error
                crash = exc
                if is_cancelled():  # nothing else handles it
                    self._report(name, first_cause(exc), 0.0, is_stopping=True)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(run, name=name)
        return crash

    def _log_state(self, name: str, state: Literal["running again", "ended"]) -> None:
        if name in self.crashes:
            self.crashes[name].state = state
        if name in self.given_up:
            self.given_up.remove(name)

    def _report(
        self, name: str, cause: BaseException, delay: float, *, is_given_up: bool = False, is_stopping: bool = False
    ) -> None:
        if isinstance(cause.__context__, BaseExceptionGroup) and first_cause(cause.__context__) is cause:
            cause.__context__ = None  # its own group: the log would show it twice
        crashes = self.crashes.setdefault(name, ComponentCrashes())
        crashes.count += 1
        crashes.last = error_text(cause)
        crashes.at = self._clock.now()
        crashes.state = "stopped" if is_stopping else "given up" if is_given_up else "restarting"
        title = self._titles[name]
        text = f"{title} crashed ({error_text(cause)})"
        place = place_of(cause)
        facts = {"component": name} if self._shown.get(name) == place else {"component": name, "exc_info": cause}
        self._shown[name] = place
        if is_stopping:
            _log.error(CRASHED, message=f"{text} while stopping", **facts)
        elif not is_given_up:
            _log.error(CRASHED, message=f"{text}; restarting in {delay:g} s", **facts)
        else:
            self.given_up.append(name)
            until = "" if delay == math.inf else f" for {_time_text(delay)}"
            _log.critical(
                GIVEN_UP,
                message=f"{title} crashed {MAX_CRASHES} times within a minute and will not be restarted{until}: "
                f"{error_text(cause)}",
                **facts,
            )


class _Start(TaskStatus[None]):
    """The outcome of a component's first start; later reports of "ready" change nothing."""

    def __init__(self) -> None:
        self.is_over = False
        self.mistake: UsageError | None = None
        self._is_decided = anyio.Event()

    def started(self, value: None = None) -> None:  # noqa: ARG002  # anyio's signature
        self.is_over = True
        self._is_decided.set()

    def stop_waiting(self) -> None:
        """Release the waiting tasks."""
        self._is_decided.set()

    async def wait(self) -> None:
        """Wait until the component is ready or has ended, or for :meth:`stop_waiting`."""
        await self._is_decided.wait()


@dataclass(frozen=True, slots=True)
class _Component:
    """A component that is kept running.

    Attributes:
        recent: The times of its crashes in the last minute, on the monotonic clock.
    """

    name: str
    work: Work
    start: _Start
    retry_after: float
    down: Callable[[str], AbstractAsyncContextManager[object]]
    recent: deque[float] = field(default_factory=deque)


def _time_text(seconds: float) -> str:
    return f"{seconds:g} s" if seconds < CRASH_WINDOW else f"{seconds / 60:.0f} minutes"
