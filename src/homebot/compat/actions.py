"""rclpy's action servers and clients."""

import asyncio
from collections.abc import Callable
from enum import IntEnum
from functools import partial
from types import SimpleNamespace
from typing import Any

from homebot.compat.messages import to_graph, to_program
from homebot.compat.remote import CONTEXT, Remote
from homebot.errors import GoalRejectedError
from homebot.graph import actions

GoalResponse = IntEnum("GoalResponse", ("REJECT", "ACCEPT"))
CancelResponse = GoalResponse


def ActionServer(  # noqa: N802 - rclpy's name
    node: Remote,
    action_type: Any,
    action_name: str,
    execute_callback: Callable[[Any], object],
    *,
    goal_callback: Callable[[Any], object] = lambda _goal: GoalResponse.ACCEPT,
    handle_accepted_callback: Callable[[Any], object] | None = None,
    cancel_callback: Callable[[Any], object] = lambda _handle: GoalResponse.REJECT,
    **_: object,
) -> Remote:
    """Execute the goals of an action: *execute_callback* takes a goal's handle, ends it and returns the result.

    With a *handle_accepted_callback*, execution starts when this, or a later callback, calls ``execute`` of the handle.
    """
    execute = node.callback(execute_callback)

    async def execute_later(goal: Any) -> Any:
        loop, handle = asyncio.get_running_loop(), node.shown(goal)
        begun = asyncio.Event()
        handle.execute = lambda *_: loop.call_soon_threadsafe(begun.set)
        (handle_accepted_callback or bool)(handle)  # here, because the execution may block the spinning thread
        await begun.wait()
        return await execute(handle)

    server = CONTEXT.call(
        actions.ActionServer,
        node.graph_object,
        to_graph(action_type),
        action_name,
        execute if handle_accepted_callback is None else execute_later,
        on_goal=lambda goal: goal_callback(node.shown(goal)) is GoalResponse.ACCEPT,
        on_cancel=lambda goal: cancel_callback(node.shown(goal)) is GoalResponse.ACCEPT,
    )
    return Remote(server, node.executor)


def ActionClient(  # noqa: N802 - rclpy's name
    node: Remote, action_type: Any, action_name: str, **_: object
) -> Any:
    """Return an action client; its ``send_goal_async`` returns a future for the goal handle."""
    client: Any = Remote(
        CONTEXT.call(actions.ActionClient, node.graph_object, to_graph(action_type), action_name), node.executor
    )

    async def send_goal(goal: Any, on_feedback: Any) -> Any:
        try:
            sent = client.shown(await client.graph_object.send_goal(goal, on_feedback))
        except GoalRejectedError:
            return SimpleNamespace(accepted=False)

        async def outcome() -> SimpleNamespace:
            status, result = await sent.graph_object.result()
            return SimpleNamespace(status=int(status), result=to_program(result))

        sent.accepted = True
        sent.get_result_async = partial(sent.begin, outcome)
        sent.cancel_goal_async = partial(sent.begin, sent.graph_object.cancel)
        return sent

    def send_goal_async(goal: Any, feedback_callback: Callable[[Any], object] = bool) -> Any:
        return client.begin(send_goal, goal, lambda feedback: feedback_callback(SimpleNamespace(feedback=feedback)))

    def send_goal_and_wait(goal: Any, **kwargs: Any) -> Any:
        handle = send_goal_async(goal, **kwargs).wait()
        return handle.get_result_async().wait() if handle.accepted else None

    client.send_goal_async, client.send_goal = send_goal_async, send_goal_and_wait
    return client
