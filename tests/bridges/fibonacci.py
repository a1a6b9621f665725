"""The action of ROS's tutorials, and a server of it."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio

from homebot.graph import Graph, Node
from homebot.graph.actions import ActionServer, ServerGoal
from homebot.messages.action import ActionType
from homebot.messages.message import Int32, Message


class FibonacciGoal(Message, ros_type="example_interfaces/action/Fibonacci_Goal"):
    """How many numbers."""

    order: Int32


class FibonacciResult(Message, ros_type="example_interfaces/action/Fibonacci_Result"):
    """All numbers."""

    sequence: tuple[Int32, ...]


class FibonacciFeedback(Message, ros_type="example_interfaces/action/Fibonacci_Feedback"):
    """The numbers so far."""

    sequence: tuple[Int32, ...]


FIBONACCI = ActionType("example_interfaces/action/Fibonacci", FibonacciGoal, FibonacciResult, FibonacciFeedback)


async def execute(goal: ServerGoal[Any, Any, Any]) -> FibonacciResult | None:
    """Count to three with feedback; of order 50 wait for ever, of order 7 fail."""
    if goal.request.order == 50:
        await anyio.sleep_forever()
    if goal.request.order == 7:
        goal.abort(FibonacciResult(sequence=(7,)))
        return None
    for last in range(3):
        goal.publish_feedback(FibonacciFeedback(sequence=tuple(range(last + 1))))
    goal.succeed()
    return FibonacciResult(sequence=(0, 1, 1))


@asynccontextmanager
async def server(graph: Graph) -> AsyncIterator[ActionServer[Any, Any, Any]]:
    """Serve ``/fib``; a goal below zero is rejected."""
    async with Node(graph, "counter") as node:
        yield ActionServer(node, FIBONACCI, "/fib", execute, on_goal=lambda goal: goal.order >= 0)
