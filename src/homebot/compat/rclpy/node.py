"""A node in the form of rclpy: subclassed, without ``async``, with callbacks on the thread that spins it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

from homebot.compat.interfaces import (
    AnyMessage,
    AnyService,
    InterfaceMessage,
    ServiceInterface,
    from_message,
    message_class,
    to_message,
    to_message_type,
    to_service,
)
from homebot.compat.rclpy.context import CONTEXT
from homebot.compat.rclpy.logging import Logger
from homebot.compat.rclpy.parameter import Parameter
from homebot.compat.rclpy.task import CallbackQueue, Future
from homebot.errors import HomebotError, ParameterError
from homebot.graph import Graph
from homebot.graph import Node as GraphNode
from homebot.graph import Parameter as GraphParameter
from homebot.graph import ParameterDescriptor as GraphDescriptor
from homebot.graph import Publisher as GraphPublisher
from homebot.graph import Service as GraphService
from homebot.graph import Subscription as GraphSubscription
from homebot.graph import Timer as GraphTimer
from homebot.graph.parameter_services import offer_parameter_services
from homebot.graph.parameters import Value
from homebot.graph.qos import QoSLike
from homebot.messages.interfaces import find_message
from homebot.messages.message import Message, ServiceType

__all__ = ["Client", "Endpoint", "Node", "Publisher", "Timer"]

FOREVER: Final = 1e9
"""Seconds: a call of rclpy has no time limit."""


class Node:
    """A node, which runs from here to :meth:`destroy_node`; its callbacks run while it spins.

    Args:
        node_name: ``[A-Za-z0-9_]``.
        namespace: Where its relative names begin.
        parameter_overrides: Values that replace the defaults of parameters declared later.

    Raises:
        InvalidNameError: A name is illegal.
        DuplicateNameError: Another node has the name.
        UsageError: ``rclpy.init()`` was not called.
    """

    def __init__(self, node_name: str, *, namespace: str = "", parameter_overrides: Sequence[Parameter] = ()) -> None:
        overrides = {one.name: one.value for one in parameter_overrides if one.value is not None}
        self.callbacks = CallbackQueue()
        self._checks: list[Callable[[list[Parameter]], InterfaceMessage | Message]] = []

        def make(graph: Graph) -> GraphNode:
            node = GraphNode(graph, node_name, namespace=namespace or "/", parameters=overrides)
            node.parameters.add_on_set_callback(self._check)
            return node

        self.graph_node = CONTEXT.add_node(self.callbacks, make)

    def get_name(self) -> str:
        """Return the name, without the namespace."""
        return self.graph_node.name

    def get_namespace(self) -> str:
        """Return the namespace."""
        return self.graph_node.namespace

    def get_logger(self) -> Logger:
        """Return the node's logger."""
        return Logger(self.graph_node.full_name)

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each topic of the graph with its type."""
        topics = CONTEXT.call(self.graph_node.graph.get_topic_names_and_types)
        return [(name, [ros_type]) for name, ros_type in topics.items()]

    def create_publisher(self, msg_type: AnyMessage, topic: str, qos_profile: QoSLike) -> Publisher:
        """Return a publisher of *msg_type* on *topic*."""
        kind = to_message_type(msg_type)
        return Publisher(CONTEXT.call(partial(self.graph_node.create_publisher, kind, topic, qos_profile)), kind)

    def create_subscription(
        self, msg_type: AnyMessage, topic: str, callback: Callable[[Any], object], qos_profile: QoSLike
    ) -> Endpoint:
        """Call *callback* with each message on *topic*, one at a time."""

        async def on_message(message: Message) -> None:
            await self.callbacks.run(callback, from_message(message))

        kind = to_message_type(msg_type)
        return Endpoint(
            CONTEXT.call(partial(self.graph_node.create_subscription, kind, topic, on_message, qos_profile))
        )

    def create_service(self, srv_type: AnyService, srv_name: str, callback: Callable[[Any, Any], object]) -> Endpoint:
        """Serve *srv_name*: *callback* takes a request and an empty response, and returns the response."""
        service = to_service(srv_type)
        response_type = service.service_type.Response

        async def handle(request: Message) -> Message:
            response = await self.callbacks.run(callback, from_message(request), service.Response())
            return to_message(response, response_type)

        kind: ServiceType[Any, Any] = service.service_type
        return Endpoint(CONTEXT.call(partial(self.graph_node.create_service, kind, srv_name, handle)))

    def create_client(self, srv_type: AnyService, srv_name: str) -> Client:
        """Return a client of *srv_name*."""
        return Client(self, to_service(srv_type), srv_name)

    def create_timer(self, timer_period_sec: float, callback: Callable[[], object]) -> Timer:
        """Call *callback* every *timer_period_sec* seconds."""
        return Timer(self, timer_period_sec, callback)

    def declare_parameter(
        self, name: str, value: Value, descriptor: InterfaceMessage | Message | None = None
    ) -> Parameter:
        """Declare a parameter with its default.

        Args:
            descriptor: ``rcl_interfaces/msg/ParameterDescriptor``.

        Raises:
            ParameterError: It is declared already, or the start-up value does not fit.
        """

        def declare() -> GraphParameter:
            offer_parameter_services(self.graph_node)
            return self.graph_node.declare_parameter(name, value, _descriptor(descriptor))

        return _parameter(CONTEXT.call(declare))

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return self.graph_node.parameters.has(name)

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter.

        Raises:
            ParameterError: It is not declared.
        """
        return _parameter(self.graph_node.get_parameter(name))

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[Any]:
        """Set each parameter; return a ``rcl_interfaces/msg/SetParametersResult`` for each."""
        return [CONTEXT.call(partial(self._set, one)) for one in parameter_list]

    def add_on_set_parameters_callback(self, callback: Callable[[list[Parameter]], Any]) -> None:
        """Call *callback* before each change; it returns a ``SetParametersResult``.

        It runs on the graph's event loop, since clients may set parameters at any time; do not wait in it.
        """
        self._checks.insert(0, callback)

    def destroy_node(self) -> None:
        """Close the node with all that it created; it may be closed already."""
        CONTEXT.remove_node(self.graph_node)

    def _set(self, parameter: Parameter) -> InterfaceMessage:
        if parameter.value is None:
            return _result(successful=False, reason=f"{parameter.name!r} is declared; it cannot be unset")
        try:
            self.graph_node.parameters.set(parameter.name, parameter.value)
        except ParameterError as exc:
            return _result(successful=False, reason=str(exc))
        return _result(successful=True)

    def _check(self, parameter: GraphParameter) -> str | None:
        for check in self._checks:
            result: Any = check([_parameter(parameter)])
            if not result.successful:
                return str(result.reason)
        return None


class Publisher:
    """The writing end of a topic."""

    def __init__(self, publisher: GraphPublisher[Any], message_type: type[Message]) -> None:
        self._publisher = publisher
        self._message_type = message_type

    def publish(self, msg: InterfaceMessage | Message) -> None:
        """Publish *msg*, from any thread.

        Raises:
            TypeMismatchError: It is of another type, or a field has a wrong value.
        """
        message = to_message(msg, self._message_type)
        CONTEXT.call(partial(self._publisher.publish, message))

    def get_subscription_count(self) -> int:
        """Return how many subscriptions receive the messages."""
        return self._publisher.subscription_count

    def destroy(self) -> None:
        """Leave the topic."""
        CONTEXT.call(self._publisher.close)


class Endpoint:
    """A subscription or a service, until :meth:`destroy`."""

    def __init__(self, entity: GraphSubscription[Any] | GraphService[Any, Any]) -> None:
        self._entity = entity

    def destroy(self) -> None:
        """Leave the topic, or end the service."""
        CONTEXT.call(self._entity.close)


class Client:
    """The calling end of a service."""

    def __init__(self, node: Node, service: ServiceInterface, name: str) -> None:
        self.node = node
        self._kind: ServiceType[Any, Any] = service.service_type
        self._client = CONTEXT.call(partial(node.graph_node.create_client, self._kind, name))
        self.srv_name = self._client.service_name

    def service_is_ready(self) -> bool:
        """Return whether the service has a server."""
        return self._client.service_is_ready()

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Return whether the service has a server within *timeout_sec* seconds."""
        return CONTEXT.wait(partial(self._client.wait_for_service, timeout_sec))

    def call_async(self, request: InterfaceMessage | Message) -> Future[Any]:
        """Call the service; the future has the response once the node spins.

        Its exception is a ServiceError where there is no server, or that one failed.

        Raises:
            TypeMismatchError: *request* is of another type, or a field has a wrong value.
        """
        message = to_message(request, self._kind.Request)
        return later(self.node, partial(self._client.call, message, FOREVER))

    def destroy(self) -> None:
        """Leave the service."""
        CONTEXT.call(self._client.close)


class Timer:
    """Calls a function at a steady rate while its node spins."""

    def __init__(self, node: Node, period: float, callback: Callable[[], object]) -> None:
        async def on_time() -> None:
            await node.callbacks.run(callback)

        self._start = partial(node.graph_node.create_timer, period, on_time)
        self._timer: GraphTimer = CONTEXT.call(self._start)

    def cancel(self) -> None:
        """Stop until :meth:`reset`."""
        CONTEXT.call(self._timer.cancel)

    destroy = cancel

    def is_canceled(self) -> bool:
        """Return whether it was cancelled."""
        return self._timer.is_canceled

    def reset(self) -> None:
        """Begin a period anew, of a cancelled timer too."""
        self.cancel()
        self._timer = CONTEXT.call(self._start)


def later(node: Node, function: Callable[[], Any], convert: Callable[[Any], Any] = from_message) -> Future[Any]:
    """Return the future result of the coroutine function *function*, which *convert* takes on the spinning thread."""
    future: Future[Any] = Future()

    async def run() -> None:
        try:
            result = await function()
        except HomebotError as exc:
            error = exc
            node.callbacks.put(lambda: future.set_exception(error))
        else:
            node.callbacks.put(lambda: future.set_result(convert(result)))

    CONTEXT.portal.start_task_soon(run)
    return future


def _parameter(parameter: GraphParameter) -> Parameter:
    return Parameter(parameter.name, value=parameter.value)


def _result(**fields: object) -> InterfaceMessage:
    return message_class(find_message("rcl_interfaces/msg/SetParametersResult"))(**fields)


def _descriptor(message: InterfaceMessage | Message | None) -> GraphDescriptor | None:
    given: Any = message
    if given is None:
        return None
    span = next(iter((*given.integer_range, *given.floating_point_range)), None)
    bounds = (None, None) if span is None else (float(span.from_value), float(span.to_value))
    return GraphDescriptor(given.description, given.read_only, *bounds)
