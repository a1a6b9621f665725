"""Reactions of apps: handlers that are called with each item of live queries."""

from collections.abc import AsyncIterable, Callable, Coroutine, Hashable, Iterator, Sequence
from functools import partial
from inspect import isawaitable
from typing import Any, Final, Generic, TypeAlias, TypeVar, final

import anyio

from homebot.apps.run_modes import HandlerRuns, RunMode, check_handler
from homebot.devices.handles.follow import Became
from homebot.errors import RefusedError, UsageError
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE

ItemT = TypeVar("ItemT")
ItemHandler: TypeAlias = Callable[[ItemT], object]

_MAX_KEYS: Final = 1000


@final
class Reaction(Generic[ItemT]):
    """Calls a handler with each item, which is the cause of the call's commands even if it runs later.

    A command that makes no sense to its device ends the call; it is logged, but does not count as a failure.

    Args:
        mode: The rule for a call while an earlier one with the same key runs; see :class:`HandlerRuns`.
        most: The limit of running and waiting calls, at which ``queued`` and ``parallel`` drop the next.
        key: Returns the key of an item, such as its room; calls with different keys are independent. None for one key.
            Beyond 1,000 keys the others share one.
    """

    def __init__(
        self,
        node: Node,
        start_task: Callable[[Callable[[], Coroutine[Any, Any, Any]]], object],
        queries: Sequence[AsyncIterable[ItemT]],
        handler: ItemHandler[ItemT],
        mode: RunMode,
        most: int,
        key: Callable[[ItemT], Hashable] | None,
    ) -> None:
        if not queries or not all(hasattr(query, "__aiter__") for query in queries):
            raise UsageError("on() takes a live query, such as self.devices.follow(Light), or several")
        check_handler(handler, "the change")
        if key is not None and not callable(key):
            raise UsageError(f"key: {key!r:.60} is not a function, such as per_room")
        self.name = getattr(handler, "__name__", "handler")
        self._handler = handler
        self._key = key
        self._runs: dict[Hashable, HandlerRuns] = {}
        self._new_runs = partial(HandlerRuns, node, start_task, mode=mode, most=most, is_quiet=mode == "single")
        self._runs[None] = self._new_runs(f"handler {self.name}")
        self._scope = anyio.CancelScope()
        self._queries = queries
        self._readers = len(queries)
        start_task(partial(self._read_all, queries))

    @property
    def given_up(self) -> Iterator[HandlerRuns]:
        """The runs that are not called any more because they failed too often, of some or all keys."""
        return (run for run in tuple(self._runs.values()) if run.trouble)

    @property
    def waiting(self) -> Iterator[tuple[str, float]]:
        """The names of the devices that it waits for to stay as they are, with the remaining seconds."""
        for query in self._queries if not self._scope.cancel_called else ():
            if isinstance(query, Became):
                yield from query.waiting

    def cancel(self) -> None:
        """End the reaction and its running and waiting calls; idempotent."""
        self._scope.cancel()
        for runs in self._runs.values():
            runs.cancel()

    async def _read_all(self, queries: Sequence[AsyncIterable[ItemT]]) -> None:
        with self._scope:
            async with anyio.create_task_group() as tasks:
                for query in queries:
                    tasks.start_soon(self._read, query)

    async def _read(self, query: AsyncIterable[ItemT]) -> None:
        async for item in query:
            key = None if self._key is None else self._key(item)
            if key not in self._runs:
                key = key if len(self._runs) < _MAX_KEYS else None
                self._runs.setdefault(key, self._new_runs(f"handler {self.name} for {getattr(key, 'name', key)!r:.60}"))
            self._runs[key].start(partial(self._call, item), CURRENT_CAUSE.get())

    async def _call(self, item: ItemT) -> None:
        try:
            if isawaitable(result := self._handler(item)):
                await result
        except RefusedError:  # logged as ``app.command_failed``
            return
