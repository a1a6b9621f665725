"""Keeps components running: one that crashes is started anew, and the others do not notice.

Each component has a task of its own. A crash is logged with its traceback and followed by a new start after a growing
delay. One that crashes five times within a minute is given up. A UsageError at the first start is nobody's crash but a
mistake to be mended, and ends the start of homebot.
"""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Awaitable
from contextlib import asynccontextmanager
from typing import Protocol

import anyio
import structlog
from anyio.abc import TaskStatus

from homebot.clock import Clock
from homebot.errors import UsageError

__all__ = ["Supervisor", "Work"]

CRASHED = "runtime.crashed"
GIVEN_UP = "runtime.given_up"

FIRST_DELAY = 0.5
MAX_DELAY = 15.0
MAX_CRASHES = 5
CRASH_WINDOW = 60.0

_log = structlog.get_logger(node="/homebot")


class Work(Protocol):
    """What a component does until it is cancelled or done; it says when it is ready."""

    def __call__(self, *, task_status: TaskStatus[None]) -> Awaitable[None]:
        """Work; an exception is a crash, returning is the end."""
        ...


class Supervisor:
    """Starts, restarts and gives up components.

    Args:
        clock: The time that crashes are counted by.

    Attributes:
        restarts: How often each component was started anew.
        given_up: The components that kept crashing.
    """

    def __init__(self, clock: Clock) -> None:
        self.restarts: dict[str, int] = {}
        self.given_up: list[str] = []
        self._clock = clock

    @asynccontextmanager
    async def running(self, name: str, work: Work) -> AsyncIterator[None]:
        """Keep *work* running inside the block; entering waits until it is ready, leaving until it is over.

        Raises:
            UsageError: The component cannot be started as it is configured.
        """
        start = _Start()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._keep, name, work, start)
            await start.over.wait()
            if start.mistake is None:
                yield
            tasks.cancel_scope.cancel()
        if start.mistake is not None:
            raise start.mistake

    async def _keep(self, name: str, work: Work, start: _Start) -> None:
        crashes: deque[float] = deque(maxlen=MAX_CRASHES)
        while True:
            try:
                await work(task_status=start)
            except Exception as exc:  # noqa: BLE001  # a supervisor is there for whatever comes
                cause = _first_cause(exc)
                if isinstance(cause, UsageError) and not start.over.is_set():
                    start.mistake = cause
                    start.started()
                    return
                crashes.append(self._clock.monotonic())
                if len(crashes) == MAX_CRASHES and crashes[-1] - crashes[0] < CRASH_WINDOW:
                    self._give_up(name, cause)
                    start.started()
                    return
                delay = min(MAX_DELAY, FIRST_DELAY * 2 ** (len(crashes) - 1))
                _log.error(
                    CRASHED,
                    message=f"{name} crashed ({_in_words(cause)}); it is started anew in {delay:g} s",
                    component=name,
                    exc_info=cause,
                )
                start.started()  # homebot starts without it rather than not at all
                await anyio.sleep(delay)
                self.restarts[name] = self.restarts.get(name, 0) + 1
            else:
                start.started()
                return

    def _give_up(self, name: str, cause: BaseException) -> None:
        self.given_up.append(name)
        _log.critical(
            GIVEN_UP,
            message=f"{name} crashed {MAX_CRASHES} times within a minute and is given up: {_in_words(cause)}",
            component=name,
            exc_info=cause,
        )


class _Start(TaskStatus[None]):
    """How the first start of a component went; a restarted one says "ready" again, which changes nothing."""

    def __init__(self) -> None:
        self.over = anyio.Event()
        self.mistake: UsageError | None = None

    def started(self, value: None = None) -> None:  # noqa: ARG002  # anyio's signature
        self.over.set()


def _first_cause(error: BaseException) -> BaseException:
    """The first real error inside what task groups wrapped around it."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


def _in_words(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
