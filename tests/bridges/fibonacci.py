"""A server of the action of ROS's tutorials."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
from tests.graph.actions.fibonacci import Feedback, Fibonacci, Result, Served

from homebot.graph import Graph, Node
from homebot.graph.actions import ActionServer


async def execute(goal: Served) -> Result | None:
    """Count to three with feedback; of order 50 wait for ever, of order 7 fail."""
    if goal.request.order == 50:
        await anyio.sleep_forever()
    if goal.request.order == 7:
        goal.abort(Result(sequence=(7,)))
        return None
    for last in range(3):
        goal.publish_feedback(Feedback(sequence=tuple(range(last + 1))))
    goal.succeed()
    return Result(sequence=(0, 1, 1))


@asynccontextmanager
async def server(graph: Graph) -> AsyncIterator[ActionServer[Any, Any, Any]]:
    """Serve ``/fib``; a goal below zero is rejected."""
    async with Node(graph, "counter") as node:
        yield ActionServer(node, Fibonacci, "/fib", execute, on_goal=lambda goal: goal.order >= 0)
