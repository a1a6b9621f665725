"""The graph shared by the programs of a process, usable from any thread, and proxies of its objects.

Its event loop has its own thread, from the first ``rclpy.init()`` to ``rclpy.shutdown()``, which ends it for all.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import queue
import threading
import time
from collections.abc import Awaitable, Callable, Generator, Mapping
from contextlib import ExitStack
from functools import partial
from inspect import iscoroutine
from types import MappingProxyType
from typing import Any, Final

import structlog
from anyio.from_thread import BlockingPortal, start_blocking_portal

from homebot.compat.messages import to_graph, to_program
from homebot.errors import UsageError
from homebot.graph import Graph, Node, RosoutFeed
from homebot.log import configure_logging
from homebot.support.logger import observed_lines

_GETTERS: Final = {
    "get_fully_qualified_name": "full_name",
    "get_name": "name",
    "get_namespace": "namespace",
    "get_subscription_count": "subscription_count",
    "is_canceled": "is_canceled",
}
_NAMES: Final = {
    "destroy": "close",
    "resolve_service_name": "resolve_name",
    "resolve_topic_name": "resolve_name",
    "srv_name": "service_name",
    "timeout_sec": "timeout",
}
_UNUSED: Final = frozenset({"callback_group", "qos_overriding_options"})
"""The callbacks of a node run one after the other, as in one group."""


class _Context:
    """A graph with the nodes that the programs of this process created."""

    def __init__(self) -> None:
        self._portal: BlockingPortal | None = None
        self._thread = 0
        self._ended_by = 0
        self._exits = ExitStack()

    @property
    def portal(self) -> BlockingPortal:
        if self._portal is None:
            raise UsageError("rclpy is not initialized; call rclpy.init() first")
        return self._portal

    def ok(self) -> bool:
        return self._portal is not None

    def is_ended_by_another(self) -> bool:
        """Return whether another thread shut the graph down."""
        return self._portal is None and self._ended_by not in {0, threading.get_ident()}

    def init(self) -> None:
        if self._portal is not None:
            return
        if not structlog.is_configured():
            configure_logging()
        self._portal = portal = self._exits.enter_context(start_blocking_portal("asyncio"))
        self._exits.callback(portal.call, partial(portal.stop, cancel_remaining=True))
        self._thread = self.call(threading.get_ident)
        self.graph: Graph = self.call(Graph)
        self._exits.enter_context(observed_lines(self.call(lambda: RosoutFeed(Node(self.graph, "rosout")))))

    def shutdown(self) -> None:
        """Close the nodes, and end each ``spin`` and the event loop; idempotent."""
        if self._portal is not None:
            self._ended_by = threading.get_ident()
        self._portal, self._thread = None, 0
        self._exits.pop_all().close()  # only effective in the first of several threads

    def add_node(self, name: str, namespace: str, names: Mapping[str, str], executor: SpinExecutor) -> Node:
        """Return a new running node with other *names* of its ends; a shutdown ends a wait of its *executor*."""
        node: Node = self.call(lambda: _RenamingNode(self.graph, name, namespace=namespace))
        vars(node).update(names={node.resolve_name(old): node.resolve_name(new) for old, new in names.items()})
        self._exits.enter_context(self.portal.wrap_async_context_manager(node))
        self._exits.callback(partial(executor.submit, int))
        return node

    def call(self, function: Callable[..., Any], *args: object, **kwargs: object) -> Any:
        """Return the result of *function*, which may be a coroutine function, on the event loop.

        Raises:
            UsageError: There is no graph, or it ended meanwhile.
        """
        if threading.get_ident() == self._thread:  # in a check of a parameter that a client sets
            return function(*args, **kwargs)
        try:
            return self.portal.call(partial(function, *args, **kwargs))
        except concurrent.futures.CancelledError:
            raise UsageError("rclpy was shut down meanwhile") from None


class _RenamingNode(Node):
    names: Mapping[str, str] = MappingProxyType({})

    def resolve_name(self, name: str, kind: str = "topic name") -> str:
        full = super().resolve_name(name, kind)
        return self.names.get(full, full)


CONTEXT: Final = _Context()
"""The context of the process."""


class _DueCallbacks(queue.SimpleQueue[tuple[concurrent.futures.Future[Any], Callable[[], object]]]):
    thread = 0


class SpinExecutor(concurrent.futures.Executor):
    """The thread that spins one or several nodes and runs their callbacks.

    Few callbacks are queued: at most one for each subscription, service and timer.
    """

    def __init__(self, num_threads: int | None = None) -> None:  # noqa: ARG002 - more of them change nothing
        self._is_shut_down = False
        self.due = _DueCallbacks()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> concurrent.futures.Future[Any]:
        """Return a future of the result of *fn*, whose exception is also raised on the spinning thread."""
        future: concurrent.futures.Future[Any] = concurrent.futures.Future()
        self.due.put((future, partial(fn, *args, **kwargs)))
        return future

    def create_task(self, callback: Callable[..., object], *args: object) -> Future:
        """Return a future of the result of *callback*, which may be a coroutine function."""
        future = Future(self)
        self.due.put((future, partial(callback, *args)))
        return future

    def add_node(self, node: Remote) -> bool:
        """Also run the callbacks of *node* on the thread that spins this executor."""
        waiting, node.executor.due = node.executor.due, self.due
        while waiting is not self.due and not waiting.empty():
            self.due.put(waiting.get())
        return True

    def remove_node(self, node: Remote) -> None:
        """Leave the callbacks of *node* to another executor."""
        node.executor.due = _DueCallbacks()

    def spin(self) -> None:
        """Run callbacks until the graph or this executor is shut down."""
        while CONTEXT.ok() and not self._is_shut_down:
            self.spin_once()

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until *future* is done or *timeout_sec* seconds have passed."""
        ends = None if timeout_sec is None else time.monotonic() + timeout_sec
        while not future.done() and CONTEXT.ok() and (ends is None or time.monotonic() < ends):
            self.spin_once(None if ends is None else max(0.0, ends - time.monotonic()))

    def shutdown(self, *_: object, **__: object) -> None:
        """End a spin."""
        self._is_shut_down = True
        self.submit(int)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run the next callback, waiting up to *timeout_sec* seconds for one; its exception is raised here."""
        self.due.thread = threading.get_ident()
        try:
            future, call = self.due.get(timeout=timeout_sec)
        except queue.Empty:
            return
        if future.set_running_or_notify_cancel():  # otherwise the node was closed meanwhile
            try:
                future.set_result(self._complete(call()))
            except Exception as exc:
                future.set_exception(exc)
                raise

    def _complete(self, result: object) -> object:
        """Return *result*, or that of a coroutine; other callbacks run while it waits."""
        while iscoroutine(result):
            try:
                result.send(None)
            except StopIteration as stop:
                return stop.value
            self.spin_once()
        return result


class Future(concurrent.futures.Future[Any]):
    """The result of a call: ``await`` it in a coroutine callback, ``spin_until_future_complete`` elsewhere.

    Args:
        executor: Runs its callbacks; by default the thread that sets the result does.
    """

    def __init__(self, executor: SpinExecutor | None = None) -> None:
        super().__init__()
        self._executor = executor
        self.add_done_callback(bool)  # ends a wait

    def __await__(self) -> Generator[None, None, Any]:
        while not self.done():
            yield
        return self.result()

    def wait(self, timeout: float | None = None) -> Any:
        """Wait for the result and return it; on the spinning thread, other callbacks run meanwhile."""
        if self._executor is not None and self._executor.due.thread == threading.get_ident():
            self._executor.spin_until_future_complete(self, timeout)
            timeout = 0
        return super().result(timeout)

    def result(self, timeout: float | None = None) -> Any:
        """Return the result, or raise the exception; return None before it is done."""
        return super().result(timeout) if self.done() else None

    def add_done_callback(self, callback: Callable[[Any], object]) -> None:
        """Call *callback* with this future once it is done, on the spinning thread."""
        super().add_done_callback(callback if self._executor is None else partial(self._executor.submit, callback))


class Remote:
    """Proxy of a graph object with rclpy's names: its methods run on the event loop, and messages are converted.

    A function among the arguments is a callback, which runs on the spinning thread.

    Args:
        graph_object: A node, a publisher, a goal and so on; see there for its methods.
    """

    def __init__(self, graph_object: Any, executor: SpinExecutor) -> None:
        self.graph_object = graph_object
        self.executor = executor

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "graph_object":  # a subclass may access it before it is set
            raise AttributeError(name)
        if name in _GETTERS:
            return lambda: getattr(self.graph_object, _GETTERS[name])
        value = getattr(self.graph_object, _NAMES.get(name, name))
        return partial(self.invoke, value) if callable(value) else self.shown(value)

    def invoke(self, method: Callable[..., Any], *args: object, event_callbacks: Any = None, **kwargs: object) -> Any:
        """Return the result of *method* on the event loop, with *event_callbacks* if it is the end of a topic."""
        given = {_NAMES.get(name, name): self._given(value) for name, value in kwargs.items() if name not in _UNUSED}
        result = self.shown(CONTEXT.call(method, *map(self._given, args), **given))
        if event_callbacks is not None:
            event_callbacks.watch(result)
        return result

    def begin(self, method: Callable[..., Awaitable[object]], *args: object) -> Future:
        """Return a future of the result of the coroutine function *method* on the event loop."""
        future = Future(self.executor)
        given = [self._given(value) for value in args]

        async def run() -> None:
            try:
                result = self.shown(await method(*given))
            except Exception as exc:  # noqa: BLE001 - raised where the result is asked for
                future.set_exception(exc)
            else:
                future.set_result(result)

        CONTEXT.portal.start_task_soon(run)
        return future

    def callback(self, function: Callable[..., object]) -> Callable[..., Awaitable[Any]]:
        """Return the coroutine function that runs *function* on the spinning thread."""

        async def run(*args: object) -> Any:
            shown = map(self.shown, args)
            return to_graph(await asyncio.wrap_future(self.executor.submit(function, *shown)))

        return run

    def shown(self, value: object) -> Any:
        """Return *value* for a program: messages become mutable, and graph objects become proxies."""
        is_of_graph = type(value).__module__.startswith("homebot.graph.") and not isinstance(value, int)
        return Remote(value, self.executor) if is_of_graph else to_program(value)

    def _given(self, value: Any) -> Any:
        return self.callback(value) if callable(value) and not isinstance(value, type) else to_graph(value)
