"""The tasks of a node: those that it starts, and those of its service handlers."""

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import AsyncExitStack
from types import TracebackType
from typing import TypeAlias, final

import anyio
from anyio.abc import TaskGroup

from homebot.errors import UsageError
from homebot.support.isolation import is_cancelled, isolated, only_cause

_Function: TypeAlias = Callable[[], Coroutine[object, object, None]]


@final
class NodeTasks:
    """The tasks of one node; tasks started before the node runs begin when it does.

    Args:
        cancel_handlers: Called at the end of the node to cancel the running handlers, each by its own scope.
    """

    def __init__(self, name: str, cancel_handlers: Callable[[], None]) -> None:
        self._name = name
        self._cancel_handlers = cancel_handlers
        self._group: TaskGroup | None = None
        self._handlers: asyncio.TaskGroup | None = None  # of service handlers, which have their own scopes
        self._exits = AsyncExitStack()
        self._scopes: dict[anyio.CancelScope, None] = {}  # in order of start, for reproducible runs
        self._waiting: list[_Function] = []

    @property
    def are_running(self) -> bool:
        """True from the beginning of the node's block to its end."""
        return self._group is not None

    def start(self, function: _Function) -> None:
        """Start a task."""
        if self._group is None:
            self._waiting.append(function)
        else:
            self._group.start_soon(self._run, function, name=self._name)

    def start_handler(self, serve: _Function) -> bool:
        """Start the task of a handler, which isolates itself; return False if the node does not run."""
        if self._handlers is None:
            return False
        self._handlers.create_task(serve(), name=self._name)
        return True

    def cancel(self) -> None:
        """Cancel all tasks except those of handlers; the block of the node continues."""
        for scope in tuple(self._scopes):
            scope.cancel()

    async def enter(self) -> None:
        """Start the tasks that waited for the node to run."""
        if self._group is not None:
            raise UsageError(f"the node {self._name} is already running")
        self._group = await self._exits.enter_async_context(anyio.create_task_group())
        self._handlers = await asyncio.TaskGroup().__aenter__()
        self._exits.push_async_callback(self._end_handlers, self._handlers)
        waiting, self._waiting = self._waiting, []
        for function in waiting:
            self.start(function)

    async def exit(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> bool | None:
        """End all running tasks; return whether *exc*, the error of the block, was only caused by their cancellation.

        Raises:
            Exception: The error of a task, or a group of several.
        """
        group, self._group, self._handlers = self._group, None, None
        if group is not None:
            group.cancel_scope.cancel()
        try:
            return await self._exits.__aexit__(exc_type, exc, traceback)
        except BaseExceptionGroup as errors:
            only = only_cause(errors)
            if only is None:
                raise
        if only is exc:
            return False
        context = only.__context__
        try:
            raise only
        finally:
            only.__context__ = context  # not its group: a log would show it twice

    async def _end_handlers(self, handlers: asyncio.TaskGroup) -> None:
        self._cancel_handlers()
        with anyio.CancelScope(shield=True):  # the group would cancel the handlers despite their shields
            await handlers.__aexit__(None, None, None)

    async def _run(self, function: _Function) -> None:
        """Run a task in its own scope: closing the node ends its tasks, not the caller's."""
        scope = anyio.CancelScope()
        try:
            with scope:
                self._scopes[scope] = None
                try:
                    with isolated(self._name):
                        await function()
                finally:
                    self._scopes.pop(scope, None)
        except asyncio.CancelledError:
            # A task that ends anyway returns normally: a cancellation that met the node's end must not end the block.
            if not scope.cancel_called and not is_cancelled():
                raise
