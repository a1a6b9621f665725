"""Programs of rclpy on homebot's graph: a node is subclassed, made, and spun, without ``async``.

Use it as ``from homebot.compat import rclpy``, or run programs unchanged with ``python -m homebot.compat PROGRAM``.
The programs of a process share one graph; each may spin in a thread of its own. Callbacks run on the thread that spins
their node, and everything may be called from any thread. Unlike rclpy's, a call of a service without a server fails at
once, and ``spin`` returns when another thread calls ``shutdown``.

Not there: executors and callback groups (use one thread per node), lifecycle nodes, simulated time.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

from homebot.compat.rclpy.context import CONTEXT
from homebot.compat.rclpy.node import Node
from homebot.compat.rclpy.parameter import Parameter
from homebot.compat.rclpy.task import Future

__all__ = [
    "Future",
    "Node",
    "Parameter",
    "create_node",
    "init",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
]


def init(*, args: Sequence[str] | None = None) -> None:  # noqa: ARG001 - rclpy's; homebot's settings are in its file
    """Start the graph of the process unless it runs already."""
    CONTEXT.init()


def ok() -> bool:
    """Return whether the graph runs: from :func:`init` to :func:`shutdown`."""
    return CONTEXT.ok()


def shutdown() -> None:
    """Close all nodes, end each spin, and the graph with them. It may have ended already."""
    CONTEXT.shutdown()


try_shutdown = shutdown


def create_node(node_name: str, *, namespace: str = "") -> Node:
    """Return a new node."""
    return Node(node_name, namespace=namespace)


def spin(node: Node) -> None:
    """Run the callbacks of *node* on this thread until :func:`shutdown`.

    Raises:
        BaseException: That of a callback, or KeyboardInterrupt.
    """
    while CONTEXT.ok():
        node.callbacks.run_next()


def spin_once(node: Node, *, timeout_sec: float | None = None) -> None:
    """Run one callback of *node*, waiting for it up to *timeout_sec* seconds, by default without limit.

    Raises:
        BaseException: That of the callback.
    """
    if CONTEXT.ok():
        node.callbacks.run_next(timeout_sec)


def spin_until_future_complete(node: Node, future: Future[object], timeout_sec: float | None = None) -> None:
    """Run the callbacks of *node* until *future* is done, *timeout_sec* seconds have passed, or :func:`shutdown`.

    Raises:
        BaseException: That of a callback; the future's own is raised by its ``result()``.
    """
    deadline = None if timeout_sec is None else time.monotonic() + timeout_sec
    while not future.done() and CONTEXT.ok():
        left = None if deadline is None else deadline - time.monotonic()
        if left is not None and left <= 0:
            return
        node.callbacks.run_next(left)
