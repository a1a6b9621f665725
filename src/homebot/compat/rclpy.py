"""Programs of rclpy on homebot's graph: a node is subclassed, made, and spun, without ``async``.

The programs of a process share one graph; each may spin in a thread of its own. Callbacks run on the thread that spins
their node, and everything may be called from any thread. The callbacks that check parameters and accept goals and
cancellations run on the graph's event loop, so that these are answered while another callback blocks; do not wait in
them. Unlike rclpy's, a call of a service without a server fails at once, and ``spin`` returns when another thread calls
``shutdown``.

Not there: multi-threaded executors and callback groups (use one thread per node), lifecycle nodes.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from enum import IntEnum
from functools import partial
from inspect import currentframe
from types import SimpleNamespace
from typing import Any, Self

from homebot import graph
from homebot.compat.messages import to_graph, to_program
from homebot.compat.remote import CONTEXT, Future, Remote, SpinExecutor
from homebot.errors import GoalRejectedError
from homebot.graph import actions, qos
from homebot.graph.parameter_services import offer_parameter_services, set_parameters
from homebot.messages import Time
from homebot.support.logger import get_logger as logger_of

__all__ = [
    "ActionClient",
    "ActionServer",
    "CancelResponse",
    "ExternalShutdownException",
    "Future",
    "GoalResponse",
    "Node",
    "Parameter",
    "SingleThreadedExecutor",
    "create_node",
    "get_logger",
    "init",
    "ok",
    "qos",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
]

GoalResponse = IntEnum("GoalResponse", ("REJECT", "ACCEPT"))
CancelResponse = GoalResponse
ExternalShutdownException = KeyboardInterrupt  # caught in a program's last line; a spin returns instead
ok = CONTEXT.ok
shutdown = try_shutdown = CONTEXT.shutdown


def init(*, args: Sequence[str] | None = None) -> ExitStack:  # noqa: ARG001 - homebot's settings are in its file
    """Start the graph of the process unless it runs already; the end of a ``with`` block shuts it down."""
    CONTEXT.init()
    block = ExitStack()
    block.callback(shutdown)
    return block


def spin(node: RclpyNode) -> None:
    """Run the callbacks of *node* on this thread until :func:`shutdown`; an exception of one is raised here."""
    node.executor.spin()


def spin_once(node: RclpyNode, *, timeout_sec: float | None = None) -> None:
    """Run one callback of *node* as :func:`spin` does; wait up to *timeout_sec* seconds for it, by default for ever."""
    if ok():
        node.executor.run_next(timeout_sec)


def spin_until_future_complete(node: RclpyNode, future: Future, timeout_sec: float | None = None) -> None:
    """Run the callbacks of *node* as :func:`spin` does until *future* is done or *timeout_sec* seconds have passed."""
    ends = None if timeout_sec is None else time.monotonic() + timeout_sec
    while not future.done() and ok() and (ends is None or time.monotonic() < ends):
        node.executor.run_next(None if ends is None else max(0.0, ends - time.monotonic()))


class get_logger:  # noqa: N801 - rclpy's name
    """The logger of *name*, which writes to ``/rosout`` too: ``info``, ``warn``, ``error`` and so on.

    With ``once=True`` or ``throttle_duration_sec`` a line of the program is logged once, or once in that time.
    """

    def __init__(self, name: str) -> None:
        self._log = logger_of(node=name)
        self._next: dict[tuple[str, int], float] = {}

    def __getattr__(self, level: str) -> Callable[..., None]:
        return partial(self._write, getattr(self._log, "critical" if level == "fatal" else level))

    def _write(
        self, write: Callable[[str], object], message: object, *, once: bool = False, throttle_duration_sec: float = 0.0
    ) -> None:
        frame: Any = currentframe()
        line = (frame.f_back.f_code.co_filename, frame.f_back.f_lineno)
        if time.monotonic() >= self._next.get(line, 0.0):
            if pause := math.inf if once else throttle_duration_sec:
                self._next[line] = time.monotonic() + pause
            write(str(message))


class RclpyTime(int):
    """A point in time, or the difference of two, in nanoseconds."""

    @property
    def nanoseconds(self) -> int:
        """The whole of it."""
        return int(self)

    def __sub__(self, other: int) -> RclpyTime:
        return RclpyTime(int(self) - int(other))

    def to_msg(self) -> Any:
        """Return it as ``builtin_interfaces/msg/Time``."""
        sec, nanosec = divmod(int(self), 10**9)
        return to_program(Time(sec=sec, nanosec=nanosec))


class RclpyParameter(graph.Parameter):
    """A parameter's name and value."""

    Type = IntEnum(
        "Type",
        "NOT_SET BOOL INTEGER DOUBLE STRING BYTE_ARRAY BOOL_ARRAY INTEGER_ARRAY DOUBLE_ARRAY STRING_ARRAY",
        start=0,
    )

    def __new__(cls, name: str, type_: Type | None = None, value: Any = None) -> Self:  # noqa: ARG004
        return super().__new__(cls, name, value)

    @property
    def type_(self) -> Type:
        """The kind of the value."""
        return self.Type(self.to_message().value.type)

    def get_parameter_value(self) -> Any:
        """Return the value as ``rcl_interfaces/msg/ParameterValue``."""
        return to_program(self.to_message().value)


class RclpyNode(Remote):
    """A node, which runs from here to :meth:`destroy_node`; its callbacks run while it spins.

    Methods that are not below, such as ``create_publisher``, are those of :class:`homebot.graph.Node`.
    """

    def __init__(self, node_name: str, *, namespace: str = "") -> None:
        executor = SpinExecutor()
        super().__init__(CONTEXT.add_node(node_name, namespace or "/", executor), executor)
        self._logger = get_logger(self.graph_object.full_name)

    def get_logger(self) -> get_logger:
        """Return the logger of the node."""
        return self._logger

    def get_clock(self) -> SimpleNamespace:
        """Return the clock of the graph; its ``now()`` is a time with ``nanoseconds`` and ``to_msg()``."""
        return SimpleNamespace(now=lambda: RclpyTime(CONTEXT.graph.clock.now() * 10**9))

    def count_publishers(self, topic_name: str) -> int:
        """Return the number of publishers on *topic_name*."""
        return self._count(graph.EntityKind.PUBLISHER, topic_name)

    def count_subscribers(self, topic_name: str) -> int:
        """Return the number of subscriptions to *topic_name*."""
        return self._count(graph.EntityKind.SUBSCRIPTION, topic_name)

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each topic of the graph with its type."""
        topics = CONTEXT.call(self.graph_object.graph.get_topic_names_and_types)
        return [(name, [ros_type]) for name, ros_type in topics.items()]

    def create_service(self, srv_type: Any, srv_name: str, callback: Callable[[Any, Any], object]) -> Any:
        """Serve *srv_name*: *callback* takes a request and an empty response, and returns the response."""
        create = self.graph_object.create_service
        return self.call(create, srv_type, srv_name, lambda request: callback(request, srv_type.Response()))

    def create_client(self, srv_type: Any, srv_name: str) -> Any:
        """Return a client of *srv_name*; its ``call_async`` returns the future response, without a time limit."""
        client = self.call(self.graph_object.create_client, srv_type, srv_name)
        client.call_async = partial(client.begin, partial(client.graph_object.call, timeout=math.inf))
        return client

    def declare_parameter(self, name: str, value: Any, descriptor: Any = None) -> RclpyParameter:
        """Declare a parameter with its default, and a ``rcl_interfaces/msg/ParameterDescriptor`` if there is one."""
        limits = None
        if descriptor is not None:
            span = next(iter((*descriptor.integer_range, *descriptor.floating_point_range)), None)
            bounds = (None, None) if span is None else (float(span.from_value), float(span.to_value))
            limits = graph.ParameterDescriptor(descriptor.description, descriptor.read_only, *bounds)
        CONTEXT.call(offer_parameter_services, self.graph_object)
        CONTEXT.call(self.graph_object.declare_parameter, name, value, limits)
        return self.get_parameter(name)

    def declare_parameters(self, namespace: str, parameters: Sequence[Sequence[Any]]) -> list[RclpyParameter]:
        """Declare each of *parameters*: its name below *namespace*, its default, and a descriptor if there is one."""
        prefix = f"{namespace}." if namespace else ""
        return [self.declare_parameter(f"{prefix}{name}", *given) for name, *given in parameters]

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return bool(self.graph_object.parameters.has(name))

    def get_parameter(self, name: str) -> RclpyParameter:
        """Return a parameter."""
        return RclpyParameter(name, value=self.graph_object.get_parameter(name).value)

    def get_parameters(self, names: Sequence[str]) -> list[RclpyParameter]:
        """Return each parameter."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: RclpyParameter) -> RclpyParameter:
        """Return a parameter, or *alternative_value* if it is not declared."""
        return self.get_parameter(name) if self.has_parameter(name) else alternative_value

    def set_parameters(self, parameter_list: Sequence[RclpyParameter]) -> list[Any]:
        """Set each parameter; return a ``rcl_interfaces/msg/SetParametersResult`` for each."""
        known = self.graph_object.parameters
        return [to_program(CONTEXT.call(set_parameters, known, (one.to_message(),))) for one in parameter_list]

    def add_on_set_parameters_callback(self, callback: Callable[[list[RclpyParameter]], Any]) -> None:
        """Call *callback* before each change; it returns a ``SetParametersResult``."""

        def check(parameter: graph.Parameter) -> str | None:
            result = callback([RclpyParameter(parameter.name, value=parameter.value)])
            return None if result.successful else str(result.reason)

        CONTEXT.call(self.graph_object.parameters.add_on_set_callback, check)

    def destroy_publisher(self, end: Remote) -> bool:
        """Close *end*, which the node created."""
        CONTEXT.call(end.graph_object.close)
        return True

    destroy_subscription = destroy_client = destroy_service = destroy_timer = destroy_publisher

    def destroy_node(self) -> None:
        """Close the node with all that it created; it may be closed already."""
        if ok():
            CONTEXT.call(self.graph_object.close)

    def _count(self, kind: graph.EntityKind, topic_name: str) -> int:
        name = self.graph_object.resolve_name(topic_name)
        return len(CONTEXT.call(CONTEXT.graph.get_endpoints, kind=kind, name=name))


def ActionServer(  # noqa: N802 - rclpy's name
    node: RclpyNode,
    action_type: Any,
    action_name: str,
    execute_callback: Callable[[Any], object],
    *,
    goal_callback: Callable[[Any], object] = lambda _goal: GoalResponse.ACCEPT,
    cancel_callback: Callable[[Any], object] = lambda _handle: GoalResponse.REJECT,
) -> Remote:
    """Execute the goals of an action: *execute_callback* takes a goal's handle, ends it and returns the result."""
    server = CONTEXT.call(
        actions.ActionServer,
        node.graph_object,
        to_graph(action_type),
        action_name,
        node.callback(execute_callback),
        on_goal=lambda goal: goal_callback(node.shown(goal)) is GoalResponse.ACCEPT,
        on_cancel=lambda goal: cancel_callback(node.shown(goal)) is GoalResponse.ACCEPT,
    )
    return Remote(server, node.executor)


def ActionClient(node: RclpyNode, action_type: Any, action_name: str) -> Any:  # noqa: N802 - rclpy's name
    """Return a client of an action; its ``send_goal_async`` returns the future handle of a goal."""
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

    client.send_goal_async = send_goal_async
    return client


Node = RclpyNode
create_node = RclpyNode
SingleThreadedExecutor = SpinExecutor
Parameter = RclpyParameter
action = executors = logging = node = parameter = task = sys.modules[__name__]
