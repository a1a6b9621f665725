"""The rclpy API on homebot's graph: a node is subclassed, created, and spun, without ``async``.

The programs of a process share one graph; each may spin in its own thread. Callbacks run on the thread that spins their
node, and everything may be called from any thread. Callbacks that concern parameters and accept goals and cancellations
run on the graph's event loop, so that these are answered while another callback blocks; they must not wait. Unlike in
rclpy, a call of a service without a server fails at once, and ``spin`` returns when another thread calls ``shutdown``.

Each executor has one thread, so callback groups have no effect: a blocking service call runs other callbacks meanwhile.
Not supported: lifecycle nodes, ``parameter_event_handler``, and callbacks that wait for another one of their node by
other means.
"""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from enum import Enum, IntEnum
from functools import partial
from types import ModuleType, SimpleNamespace
from typing import Any, Final, Self

from homebot import graph
from homebot.compat.actions import ActionClient, ActionServer, CancelResponse, GoalResponse
from homebot.compat.arguments import node_rules, remove_ros_args
from homebot.compat.clock import RclpyClock, RclpyDuration, RclpyRate, RclpyTime
from homebot.compat.events import PublisherEventCallbacks, SubscriptionEventCallbacks
from homebot.compat.logger import LoggingSeverity, get_logger
from homebot.compat.messages import serialize_message, to_program
from homebot.compat.remote import CONTEXT, Future, Remote, SpinExecutor
from homebot.errors import ParameterError
from homebot.graph import qos as graph_qos
from homebot.graph.parameter_services import set_parameters
from homebot.graph.parameters import value_of
from homebot.graph.qos_events import MatchedStatus

__all__ = [
    "ActionClient",
    "ActionServer",
    "CallbackGroup",
    "CancelResponse",
    "Clock",
    "ClockType",
    "Duration",
    "Executor",
    "ExternalShutdownException",
    "Future",
    "GoalResponse",
    "InvalidParameterTypeException",
    "InvalidParameterValueException",
    "LoggingSeverity",
    "MultiThreadedExecutor",
    "MutuallyExclusiveCallbackGroup",
    "Node",
    "Parameter",
    "ParameterAlreadyDeclaredException",
    "ParameterNotDeclaredException",
    "PublisherEventCallbacks",
    "QoSPublisherMatchedInfo",
    "QoSSubscriptionMatchedInfo",
    "ROSInterruptException",
    "Rate",
    "ReentrantCallbackGroup",
    "SingleThreadedExecutor",
    "SubscriptionEventCallbacks",
    "Time",
    "create_node",
    "get_logger",
    "init",
    "ok",
    "qos",
    "remove_ros_args",
    "serialize_message",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
    "wait_for_message",
]

ExternalShutdownException = ROSInterruptException = (
    KeyboardInterrupt  # programs catch it in their last line; here a spin returns instead
)
ParameterAlreadyDeclaredException = ParameterNotDeclaredException = ParameterError
InvalidParameterTypeException = InvalidParameterValueException = ParameterError


class CallbackGroup:
    """A group of callbacks, without effect: those of an executor run one after the other."""


MutuallyExclusiveCallbackGroup = ReentrantCallbackGroup = CallbackGroup
QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo = MatchedStatus
ClockType = IntEnum("ClockType", ("ROS_TIME", "SYSTEM_TIME", "STEADY_TIME"))


class RclpyProfile(SimpleNamespace):
    """A profile with settable policies, which are validated when a publisher or subscription is created with it."""

    def __init__(self, **policies: object) -> None:
        super().__init__(**asdict(graph_qos.QoSProfile()) | policies)

    @property
    def _interface(self) -> graph_qos.QoSProfile:
        """The profile for the graph, with durations in seconds."""
        policies = vars(self)
        seconds = {name: value / 10**9 for name, value in policies.items() if isinstance(value, RclpyDuration)}
        return graph_qos.QoSProfile(**policies | seconds)


qos = ModuleType("rclpy.qos")
vars(qos).update(
    vars(graph_qos),
    QoSDurabilityPolicy=graph_qos.DurabilityPolicy,
    QoSHistoryPolicy=graph_qos.HistoryPolicy,
    QoSLivelinessPolicy=graph_qos.LivelinessPolicy,
    QoSProfile=RclpyProfile,
    QoSReliabilityPolicy=graph_qos.ReliabilityPolicy,
    qos_profile_parameters=graph_qos.qos_profile_parameter_events,
    qos_profile_system_default=graph_qos.qos_profile_default,
)
_PRESETS = {
    name.removeprefix("qos_profile_").upper(): profile for name, profile in vars(qos).items() if name.startswith("qos_")
}
vars(qos).update(QoSPresetProfiles=Enum("QoSPresetProfiles", _PRESETS))
_THREAD = threading.local()
Clock, Duration, Rate, Time = RclpyClock, RclpyDuration, RclpyRate, RclpyTime
ok = CONTEXT.ok
shutdown = try_shutdown = CONTEXT.shutdown


def init(*, args: Sequence[str] | None = None, **_: object) -> ExitStack:
    """Start the graph of the process unless it is running; the end of a ``with`` block shuts it down.

    Args:
        args: The command line of the nodes that this thread creates, with ``--ros-args``; by default the program's.
    """
    _THREAD.words = args
    CONTEXT.init()
    block = ExitStack()
    block.callback(shutdown)
    return block


def spin(node: RclpyNode, executor: SpinExecutor | None = None) -> None:
    """Run the callbacks of *node* on this thread until :func:`shutdown`; their exceptions are raised here."""
    _executor_of(node, executor).spin()


def spin_once(node: RclpyNode, *, executor: SpinExecutor | None = None, timeout_sec: float | None = None) -> None:
    """Run one callback of *node* like :func:`spin`; wait up to *timeout_sec* seconds for it, by default forever."""
    if ok():
        _executor_of(node, executor).spin_once(timeout_sec)


def spin_until_future_complete(
    node: RclpyNode, future: Future, executor: SpinExecutor | None = None, timeout_sec: float | None = None
) -> None:
    """Run the callbacks of *node* like :func:`spin` until *future* is done or *timeout_sec* seconds have passed."""
    _executor_of(node, executor).spin_until_future_complete(future, timeout_sec)


def wait_for_message(
    msg_type: Any, node: RclpyNode, topic: str, *, qos_profile: Any = 1, time_to_wait: float = -1
) -> tuple[bool, Any]:
    """Return whether a message came on *topic* within *time_to_wait* seconds (-1: ever), and the message."""
    first = Future(node.executor)

    def set_first(message: object) -> None:
        if not first.done():
            first.set_result(message)

    subscription = node.create_subscription(msg_type, topic, set_first, qos_profile)
    node.executor.spin_until_future_complete(first, None if time_to_wait < 0 else time_to_wait)
    node.destroy_subscription(subscription)
    return first.done(), first.result()


class RclpyParameter(graph.Parameter):
    """A parameter's name and value."""

    Type = IntEnum(
        "Type",
        "NOT_SET BOOL INTEGER DOUBLE STRING BYTE_ARRAY BOOL_ARRAY INTEGER_ARRAY DOUBLE_ARRAY STRING_ARRAY",
        start=0,
    )

    def __new__(cls, name: str, type_: Type | None = None, value: Any = None) -> Self:  # noqa: ARG004
        return super().__new__(cls, name, to_program(value))

    @property
    def type_(self) -> Type:
        """The kind of the value."""
        return self.Type(self.to_message().value.type)

    def get_parameter_value(self) -> Any:
        """Return the value as ``rcl_interfaces/msg/ParameterValue``."""
        return to_program(self.to_message().value)


_ZEROS: Final = (None, False, 0, 0.0, "", b"", *((),) * 4)
"""The value of a parameter that is declared only by its type."""


class RclpyNode(Remote):
    """A node, which runs until :meth:`destroy_node`; its callbacks run while it spins.

    Methods that are not defined here, such as ``create_publisher``, are those of :class:`homebot.graph.Node`.
    """

    def __init__(
        self,
        node_name: str,
        *,
        namespace: str = "",
        parameter_overrides: Sequence[RclpyParameter] = (),
        automatically_declare_parameters_from_overrides: bool = False,
        **_: object,
    ) -> None:
        executor, words = SpinExecutor(), getattr(_THREAD, "words", None)
        names, values = node_rules(sys.argv if words is None else words, node_name)
        name, namespace = names.pop("__node", node_name), names.pop("__ns", namespace or "/")
        super().__init__(CONTEXT.add_node(name, namespace, names, executor), executor)
        self._logger = get_logger(self.graph_object.full_name)
        self._overrides = {given.name: given.value for given in parameter_overrides or ()} | values
        for declared in self._overrides if automatically_declare_parameters_from_overrides else ():
            self.declare_parameter(declared)

    def get_logger(self) -> get_logger:
        """Return the logger of the node."""
        return self._logger

    def get_clock(self) -> RclpyClock:
        """Return the clock of the graph."""
        return RclpyClock()

    def create_rate(self, frequency: float) -> RclpyRate:
        """Return a rate, in Hertz."""
        return RclpyRate(frequency)

    def count_publishers(self, topic_name: str) -> int:
        """Return the number of publishers on *topic_name*."""
        return self._count(graph.EntityKind.PUBLISHER, topic_name)

    def count_subscribers(self, topic_name: str) -> int:
        """Return the number of subscriptions to *topic_name*."""
        return self._count(graph.EntityKind.SUBSCRIPTION, topic_name)

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes, without their namespaces."""
        return [name.rpartition("/")[2] for name in CONTEXT.call(self.graph_object.graph.get_node_names)]

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each topic of the graph with its type."""
        return _with_lists(CONTEXT.call(self.graph_object.graph.get_topic_names_and_types))

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each service of the graph with its type."""
        return _with_lists(CONTEXT.call(self.graph_object.graph.get_service_names_and_types))

    def create_timer(
        self, timer_period_sec: float, callback: Callable[[], object], *_: object, autostart: bool = True, **__: object
    ) -> Any:
        """Call *callback* once per period; ``reset()`` restarts it, even after ``cancel()``."""
        create = partial(CONTEXT.call, self.graph_object.create_timer, timer_period_sec, self.callback(callback))
        timer: Any = Remote(create(), self.executor)

        def reset() -> None:
            timer.cancel()
            timer.graph_object = create()

        timer.reset, timer.destroy = reset, timer.cancel
        if not autostart:
            timer.cancel()
        return timer

    def create_guard_condition(self, callback: Callable[[], object], **_: object) -> Any:
        """Return an object with a ``trigger()`` that runs *callback*."""
        return SimpleNamespace(trigger=partial(self.executor.submit, callback), destroy=bool)

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[[Any], object], *qos: Any, raw: bool = False, **more: Any
    ) -> Any:
        """Call *callback* with each message on *topic*; with *raw*, with its bytes in CDR."""
        handler = (lambda message: callback(serialize_message(message))) if raw else callback
        return self.invoke(self.graph_object.create_subscription, msg_type, topic, handler, *qos, **more)

    def create_service(self, srv_type: Any, srv_name: str, callback: Callable[[Any, Any], object], **_: object) -> Any:
        """Serve *srv_name*: *callback* takes a request and an empty response, and returns the response."""
        create = self.graph_object.create_service
        return self.invoke(create, srv_type, srv_name, lambda request: callback(request, srv_type.Response()))

    def create_client(self, srv_type: Any, srv_name: str, **_: object) -> Any:
        """Return a client of *srv_name*; its ``call_async`` returns a future of the response, without a time limit."""
        client = self.invoke(self.graph_object.create_client, srv_type, srv_name)
        client.call_async = partial(client.begin, partial(client.graph_object.call, timeout=math.inf))
        client.call = lambda request, timeout_sec=None: client.call_async(request).wait(timeout_sec)
        return client

    def declare_parameter(self, name: str, value: Any = None, descriptor: Any = None) -> RclpyParameter:
        """Declare a parameter with its default or type, and perhaps a ``rcl_interfaces/msg/ParameterDescriptor``.

        A parameter with only a type is zero or empty, unless it is overridden.
        """
        value = self._overrides.get(name, value)
        if isinstance(value, RclpyParameter.Type):
            value = _ZEROS[value]
        limits = None
        if descriptor is not None:
            span = next(iter((*descriptor.integer_range, *descriptor.floating_point_range)), None)
            bounds = (None, None) if span is None else (float(span.from_value), float(span.to_value))
            limits = graph.ParameterDescriptor(descriptor.description, descriptor.read_only, *bounds)
        CONTEXT.call(self.graph_object.declare_parameter, name, value, limits)
        return self.get_parameter(name)

    def declare_parameters(self, namespace: str, parameters: Sequence[Sequence[Any]]) -> list[RclpyParameter]:
        """Declare *parameters*, each with its name below *namespace*, its default, and perhaps a descriptor."""
        prefix = f"{namespace}." if namespace else ""
        return [self.declare_parameter(f"{prefix}{name}", *given) for name, *given in parameters]

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, RclpyParameter]:
        """Return the parameters below *prefix*, by the rest of their names."""
        names = self.graph_object.parameters.names()
        by_rest = {
            name.removeprefix(f"{prefix}."): name for name in names if not prefix or name.startswith(f"{prefix}.")
        }
        return {rest: self.get_parameter(name) for rest, name in by_rest.items()}

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
        return [to_program(CONTEXT.call(set_parameters, known, (given.to_message(),))) for given in parameter_list]

    def set_parameters_atomically(self, parameter_list: Sequence[RclpyParameter]) -> Any:
        """Set all parameters or none; return a ``rcl_interfaces/msg/SetParametersResult``."""
        messages = tuple(given.to_message() for given in parameter_list)
        return to_program(CONTEXT.call(set_parameters, self.graph_object.parameters, messages))

    def add_on_set_parameters_callback(self, callback: Callable[[list[RclpyParameter]], Any]) -> None:
        """Call *callback* before each change; it returns a ``SetParametersResult``."""

        def check(parameter: graph.Parameter) -> str | None:
            result = callback([RclpyParameter(parameter.name, value=parameter.value)])
            return None if result.successful else str(result.reason)

        CONTEXT.call(self.graph_object.parameters.add_on_set_callback, check)

    def add_pre_set_parameters_callback(self, callback: Callable[[list[RclpyParameter]], Any]) -> None:
        """Set the parameters that *callback* returns in place of those of each change."""
        known = self.graph_object.parameters
        before = known.prepare
        known.prepare = lambda values: {
            given.name: value_of(given.to_message().value) for given in callback(_parameters(before(values)))
        }

    def add_post_set_parameters_callback(self, callback: Callable[[list[RclpyParameter]], object]) -> None:
        """Call *callback* after each change."""
        known = self.graph_object.parameters
        before = known.on_event

        def after(kind: str, parameters: Sequence[graph.Parameter]) -> None:
            before(kind, parameters)
            if kind == "changed":
                callback(_parameters(dict(parameters)))

        known.on_event = after

    def destroy_publisher(self, end: Remote) -> bool:
        """Close *end*, which the node created."""
        CONTEXT.call(end.graph_object.close)
        return True

    destroy_subscription = destroy_client = destroy_service = destroy_publisher

    def destroy_timer(self, timer: Remote) -> bool:
        """Stop *timer*, which the node created."""
        timer.cancel()
        return True

    def destroy_node(self) -> None:
        """Close the node and everything that it created; idempotent."""
        if ok():
            CONTEXT.call(self.graph_object.close)

    def _count(self, kind: graph.EntityKind, topic_name: str) -> int:
        name = self.graph_object.resolve_name(topic_name)
        return len(CONTEXT.call(CONTEXT.graph.get_endpoints, kind=kind, name=name))


def _executor_of(node: RclpyNode, executor: SpinExecutor | None) -> SpinExecutor:
    if executor is not None:
        executor.add_node(node)
    return executor or node.executor


def _parameters(values: Mapping[str, Any]) -> list[RclpyParameter]:
    return [RclpyParameter(name, value=value) for name, value in values.items()]


def _with_lists(types: dict[str, str]) -> list[tuple[str, list[str]]]:
    return [(name, [ros_type]) for name, ros_type in types.items()]


Node = RclpyNode
create_node = RclpyNode
Executor = SingleThreadedExecutor = MultiThreadedExecutor = SpinExecutor
Parameter = RclpyParameter
Client = Publisher = Service = Subscription = Timer = Remote
action = callback_groups = clock = duration = exceptions = executors = sys.modules[__name__]
logging = node = parameter = task = time = utilities = sys.modules[__name__]
