"""The graph that the programs of a process share, used from any thread.

Its event loop has a thread of its own, from the first ``rclpy.init()`` to ``rclpy.shutdown()``, which ends it for all;
inside a running homebot it is the graph of that (:meth:`Context.joined`).
"""

from __future__ import annotations

import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from typing import Final, TypeVar
from weakref import WeakSet

import structlog
from anyio.from_thread import BlockingPortal, start_blocking_portal

from homebot.compat.rclpy.task import CallbackQueue
from homebot.errors import UsageError
from homebot.graph import Graph, Node, RosoutFeed
from homebot.log import configure_logging
from homebot.support.logger import observed_lines

__all__ = ["CONTEXT", "Context"]

T = TypeVar("T")


class Context:
    """A graph with the nodes that the programs of this process made on it."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._portal: BlockingPortal | None = None
        self._graph: Graph | None = None
        self._loop_thread = 0
        self._loop = ExitStack()
        self._nodes: dict[Node, AbstractContextManager[Node]] = {}
        self._queues: WeakSet[CallbackQueue] = WeakSet()

    def ok(self) -> bool:
        """Return whether there is a graph."""
        return self._portal is not None

    def init(self) -> None:
        """Start the graph unless there is one."""
        with self._lock:
            if self._portal is not None:
                return
            if not structlog.is_configured():
                configure_logging()
            self._portal = self._loop.enter_context(start_blocking_portal("asyncio"))
            self._loop.callback(self._portal.call, partial(self._portal.stop, cancel_remaining=True))
            self._graph, self._loop_thread = self._portal.call(_new_graph)
            feed = self._portal.call(_new_feed, self._graph)
            self._loop.enter_context(observed_lines(feed))

    @contextmanager
    def joined(self, portal: BlockingPortal, graph: Graph) -> Iterator[None]:
        """Use *graph* during the block, which runs on its event loop, as *portal* does.

        Raises:
            UsageError: There is a graph.
        """
        if self._portal is not None:
            raise UsageError("a program of rclpy runs already; homebot takes one at a time")
        self._portal, self._graph, self._loop_thread = portal, graph, threading.get_ident()
        try:
            yield
        finally:
            self._portal = None
            self._wake()

    def shutdown(self) -> None:
        """Close the nodes and end each ``spin``, and the event loop if it is ours."""
        with self._lock:
            if self._portal is None:
                return
            for node in reversed(list(self._nodes)):
                self.remove_node(node)
            self._loop.close()
            self._portal = self._graph = None
            self._wake()

    def add_node(self, queue: CallbackQueue, make: Callable[[Graph], Node]) -> Node:
        """Return the running node that *make* makes; *queue* takes its callbacks.

        Raises:
            UsageError: There is no graph.
        """
        if self._graph is None:
            raise self._error()
        node = self.call(partial(make, self._graph))
        running = self.portal.wrap_async_context_manager(node)
        running.__enter__()
        self._nodes[node] = running
        self._queues.add(queue)
        return node

    def remove_node(self, node: Node) -> None:
        """Close *node*; it may be closed already."""
        running = self._nodes.pop(node, None)
        if running is not None and self._portal is not None:
            running.__exit__(None, None, None)

    def call(self, function: Callable[[], T]) -> T:
        """Return the result of *function* on the event loop.

        Raises:
            UsageError: There is no graph.
        """
        if threading.get_ident() == self._loop_thread:  # a check of a parameter that a client sets
            return function()
        return self.portal.call(function)

    def wait(self, function: Callable[[], Awaitable[T]]) -> T:
        """Return what *function* returns at last; exceptions are raised here."""
        return self.portal.call(function)

    @property
    def portal(self) -> BlockingPortal:
        """The way to the event loop.

        Raises:
            UsageError: There is no graph.
        """
        if self._portal is None:
            raise self._error()
        return self._portal

    def _wake(self) -> None:
        for queue in list(self._queues):
            queue.put(lambda: None)

    def _error(self) -> UsageError:
        return UsageError("rclpy is not initialized; call rclpy.init() first")


async def _new_graph() -> tuple[Graph, int]:
    return Graph(), threading.get_ident()


async def _new_feed(graph: Graph) -> RosoutFeed:
    return RosoutFeed(Node(graph, "rosout"))


CONTEXT: Final = Context()
"""That of the process."""
