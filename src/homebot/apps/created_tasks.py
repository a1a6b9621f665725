"""Tasks that the code of an app creates with asyncio, which the app watches like those of ``start_task``."""

import asyncio
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from contextvars import ContextVar
from functools import partial
from types import FrameType
from typing import Any, Final, TypeAlias, final

import anyio

from homebot.graph.service import calling_runs
from homebot.support.isolation import crash_of
from homebot.support.production_loop import is_ours

APP_NODE: Final[ContextVar[str]] = ContextVar("homebot.app_node", default="")
"""The full name of the node of the app whose code runs."""

Watch: TypeAlias = Callable[[str, FrameType, asyncio.Task[Any]], None]
"""Gets each task that code outside of homebot and asyncio creates: the app's node, the code, and the task."""

_CREATORS: Final = frozenset({"asyncio", "anyio"})
"""Packages that create tasks for who calls them: task groups, ``gather``, ``wait_for``."""


def watch_created_tasks(watch: Watch) -> None:
    """Report created tasks of this loop to *watch*; a loop that has a task factory is left alone."""
    loop = asyncio.get_running_loop()
    if loop.get_task_factory() is None:
        loop.set_task_factory(partial(_make_task, watch))


def _make_task(watch: Watch, loop: asyncio.AbstractEventLoop, work: Any, **options: Any) -> asyncio.Task[Any]:
    task = asyncio.Task(work, loop=loop, **options)
    frame: FrameType | None = sys._getframe(1)  # noqa: SLF001 - documented, as in LoopWatch
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] in _CREATORS:
        frame = frame.f_back
    if frame is not None and not is_ours(frame) and loop.is_running():
        run = next(calling_runs(), None)  # in the context of its caller
        node = APP_NODE.get() if run is None else run.server.info.node
        if node:
            watch(node, frame, task)
    return task


@final
class CreatedTasks:
    """The tasks that the code of one app has created and that have not ended; *name* is that of its node."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._tasks: dict[asyncio.Task[Any], None] = {}  # in order of creation, for reproducible runs
        self._failures: list[Exception] = []
        self._scope = anyio.CancelScope()
        self._is_over = False

    def add(self, task: asyncio.Task[Any]) -> None:
        """Watch *task*; one that is created after the app has ended is cancelled."""
        if self._is_over:
            task.cancel()
        else:
            self._tasks[task] = None
            task.add_done_callback(self._look_soon)

    @asynccontextmanager
    async def watched(self) -> AsyncIterator[None]:
        """End the block with an error that nobody awaits, and the tasks with the block.

        Raises:
            ExceptionGroup: The error of the block, and those of the tasks.
        """
        try:
            with self._scope:
                yield
                await self._all_ended()
        finally:
            error = sys.exc_info()[1]
            with anyio.CancelScope(shield=True):
                for task in self._tasks:
                    task.cancel()
                await self._all_ended()
            self._is_over = True
            if self._failures:
                errors = [error] if isinstance(error, Exception) else []
                raise ExceptionGroup(f"tasks of {self._name} failed", [*errors, *self._failures])

    def work(self) -> list[Any]:
        """Return the coroutines of the tasks."""
        return [task.get_coro() for task in self._tasks]

    def end_closed(self) -> None:
        """End the tasks, whose coroutines were closed."""
        for task in tuple(self._tasks):
            task.remove_done_callback(self._look_soon)
            task.add_done_callback(self._drop)
            task.cancel()

    async def _all_ended(self) -> None:
        while self._tasks:
            await asyncio.wait(self._tasks)
            await asyncio.sleep(0)

    def _look_soon(self, task: asyncio.Task[Any]) -> None:
        """Look for the error of *task* once those who await it, also by ``asyncio.wait()``, have had their turn."""
        loop = task.get_loop()
        loop.call_soon(loop.call_soon, self._look, task)

    def _look(self, task: asyncio.Task[Any]) -> None:
        del self._tasks[task]
        # Asyncio's own flag, and no public way to it: whether the error was never retrieved.
        if not task.cancelled() and getattr(task, "_log_traceback", False) and (error := task.exception()) is not None:
            self._failures.append(crash_of(self._name, error))
            self._scope.cancel()

    def _drop(self, task: asyncio.Task[Any]) -> None:
        del self._tasks[task]
        if not task.cancelled():
            task.exception()  # that its coroutine is closed
