"""A node: a named part of the program with its publishers, subscriptions, services, timers and parameters.

Both spellings work. rclpy's::

    node.create_subscription(String, "chatter", on_chatter, 10)

and the asynchronous one::

    async for message in node.create_subscription(String, "chatter"):
        ...

Callbacks and timers run inside ``async with node``; those created earlier start then. By default a callback receives
one message at a time, in order. An exception in a callback (even SystemExit, GeneratorExit or a stray cancellation)
costs only its message: it is logged and counted in ``graph.failures``.

An exception in one of the node's tasks ends the ``async with`` block, which raises it, or several as a group.

The class is long because it offers all operations of a node, like rclpy's; each mechanism has its own file.
"""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from functools import partial
from types import TracebackType
from typing import Any, Literal, Self, TypeVar

from structlog.typing import FilteringBoundLogger

from homebot.errors import ClosedError, DuplicateNameError
from homebot.graph.client import Client
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity, OfferedEntity
from homebot.graph.graph import Graph
from homebot.graph.mailbox import BoundedQueue
from homebot.graph.node_tasks import NodeTasks
from homebot.graph.parameters import PARAMETER_SERVICES, Parameter, ParameterDescriptor, ParameterSet, Value
from homebot.graph.publisher import History, Publisher
from homebot.graph.qos import QoSLike, qos_profile_parameter_events, to_qos_profile
from homebot.graph.service import Handler, Service, ServiceSlot
from homebot.graph.subscription import Callback, Expiring, Subscription
from homebot.graph.timer import Timer
from homebot.graph.topic import Topic
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceType
from homebot.messages.rcl_interfaces import ParameterEvent
from homebot.names import expand_name, full_node_name
from homebot.support.isolation import crash_of, uncancel
from homebot.support.logger import get_logger

MessageT = TypeVar("MessageT", bound=Message)
RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT")

_ACTION_ENDS = frozenset({EntityKind.ACTION_SERVER, EntityKind.ACTION_CLIENT})


class Node:
    """A named member of the graph.

    Names of topics, services and actions are relative, absolute, or private (``~/name``). Methods that create one of
    these raise InvalidNameError for an illegal name, TypeMismatchError if the name has another type, DuplicateNameError
    for a second server, and ClosedError on a closed node.

    Args:
        name: ``[A-Za-z0-9_]``, unique in its namespace.
        namespace: Where relative names of this node begin; ``/`` by default.

    Raises:
        InvalidNameError: The name or the namespace is illegal.
        DuplicateNameError: The graph has a node of this full name.
    """

    def __init__(
        self, graph: Graph, name: str, *, namespace: str = "/", parameters: Mapping[str, Value] | None = None
    ) -> None:
        self.graph = graph
        self.name = name
        self.full_name = full_node_name(name, namespace)
        self.namespace = self.full_name.removesuffix(f"/{name}") or "/"
        self.log = get_logger(node=self.full_name)
        self._tasks = NodeTasks(self.full_name, self._cancel_handlers)
        self._entities: dict[int, GraphEntity] = {}
        self._closed = False
        graph.add_node(self)
        self._events = self.create_publisher(ParameterEvent, "/parameter_events", qos_profile_parameter_events)
        self.parameters = ParameterSet(
            self.full_name,
            parameters or {},
            self._announce_parameters,
            self._record_check_failure,
            self._offer_parameters,
        )

    def create_publisher(
        self,
        msg_type: type[MessageT],
        topic: str,
        qos_profile: QoSLike = 10,
        *,
        history: History[MessageT] | None = None,
    ) -> Publisher[MessageT]:
        """Return a publisher of *msg_type* on *topic*.

        Args:
            qos_profile: The offered quality of service; a number is the depth of its history.
            history: Custom store of the messages for late joiners.

        Raises:
            QosError: *qos_profile* contradicts itself.
        """
        self._check_open()
        qos = to_qos_profile(qos_profile)
        channel = self.graph.topic(self.resolve_name(topic), msg_type, self.full_name)

        on_close = partial(self._leave_topic, channel)
        on_failure = partial(self._record_failure, f"event handler of {channel.name}", "its event is lost")
        publisher = Publisher(
            channel.name, msg_type, self.full_name, qos, self.graph.clock, on_close, on_failure, history
        )
        channel.add_publisher(publisher)
        self.add_entity(publisher)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callback[MessageT] | None = None,
        qos_profile: QoSLike = 10,
        *,
        concurrent: bool = False,
        from_node: str = "",
        queue: BoundedQueue[MessageT | Expiring[MessageT]] | None = None,
        names_sender: bool = False,
    ) -> Subscription[MessageT]:
        """Return a subscription to *topic*: iterate over it, or give a *callback*.

        Args:
            callback: A function or coroutine function for each message; without one, iterate.
            qos_profile: The requested quality of service; a number is the depth of the queue.
            concurrent: Whether the callback may run several times at once, up to the depth of the queue.
            from_node: Full name of the only publishing node to receive from; empty for all nodes, `OTHERS` for all but
                this one.
            queue: A custom queue; by default it has the depth of *qos_profile*.
            names_sender: Whether to record the :attr:`Subscription.sender` of each message.

        Raises:
            QosError: *qos_profile* contradicts itself.
        """
        self._check_open()
        qos = to_qos_profile(qos_profile)
        channel = self.graph.topic(self.resolve_name(topic), msg_type, self.full_name)
        on_close = partial(self._leave_topic, channel)
        on_failure = partial(self._record_failure, f"handler of {channel.name}", "its message is lost")
        subscription = Subscription(
            channel.name,
            msg_type,
            self.full_name,
            qos,
            self.graph.clock,
            on_close,
            on_failure,
            from_node,
            queue,
            names_sender=names_sender,
        )
        channel.add_subscription(subscription)
        self.add_entity(subscription)
        if callback is not None:
            run = subscription.run_concurrently if concurrent else subscription.run_in_turn
            self._tasks.start(partial(run, callback))
        return subscription

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: Handler[RequestT, ResponseT],
        *,
        concurrent: bool = False,
        cancel_with_caller: bool = False,
    ) -> Service[RequestT, ResponseT]:
        """Serve *srv_name*, which only one node may do.

        A handler that waits runs in a task of this node and continues if its caller gives up. Before the node runs,
        handlers run in the tasks of their callers and are cancelled with them.

        Args:
            concurrent: Whether up to 1,000 calls are served at once; by default they are queued.
            cancel_with_caller: Whether a handler ends with its caller, for handlers that only wait for others.

        Raises:
            DuplicateNameError: Another server has the name.
        """
        self._check_open()
        name = self.resolve_name(srv_name, "service name")
        slot = self.graph.service_slot(name, srv_type, self.full_name)
        if slot.server is not None:
            self.graph.release_service_slot(slot)
            raise DuplicateNameError(f"{name} is already served by {slot.server.info.node}")
        service = Service(
            name,
            srv_type,
            self.full_name,
            callback,
            concurrent=concurrent,
            cancel_with_caller=cancel_with_caller,
            start=self._tasks.start_handler,
            on_close=partial(self._leave_service, slot),
            failures=self.graph.failures,
        )
        slot.set_server(service)
        self.add_entity(service)
        return service

    def create_client(self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str) -> Client[RequestT, ResponseT]:
        """Return a client of the service *srv_name*, which need not have a server yet."""
        self._check_open()
        slot = self.graph.service_slot(self.resolve_name(srv_name, "service name"), srv_type, self.full_name)
        client = Client(slot, srv_type, self.full_name, partial(self._leave_service, slot), self.graph.call_limits)
        self.add_entity(client)
        return client

    def offer_action(
        self, ros_type: str, name: str, start: Callable[[], object], load: Callable[[], object] | None = None
    ) -> None:
        """Show the action *name* on the graph, and call *start* to create its server when it is first used.

        Args:
            load: Loads the modules that *start* needs; called in a thread, before it if possible.
        """
        self._offer(EntityKind.ACTION_SERVER, ros_type, self.resolve_name(name, "action name"), start, load)

    def offer_service(
        self, ros_type: str, name: str, start: Callable[[], object], load: Callable[[], object] | None = None
    ) -> None:
        """Show the service *name* on the graph; see :meth:`offer_action`."""
        self._offer(EntityKind.SERVICE, ros_type, self.resolve_name(name, "service name"), start, load)

    def _offer(
        self,
        kind: EntityKind,
        ros_type: str,
        name: str,
        start: Callable[[], object],
        load: Callable[[], object] | None,
    ) -> None:
        def start_or_offer_again() -> None:
            try:
                start()
            except Exception:
                self._offer(kind, ros_type, name, start, load)  # so that each user learns why
                raise

        self._check_open()
        info = EndpointInfo(kind, self.full_name, name, ros_type)
        offered = OfferedEntity(info, start_or_offer_again, load, self._withdraw)
        self.graph.offer(offered)
        self.add_entity(offered)

    def create_timer(self, timer_period_sec: float, callback: Callable[[], Awaitable[None] | None]) -> Timer:
        """Call *callback* every *timer_period_sec* seconds, first one period from now or from the node's start.

        Raises:
            UsageError: The period is not above 0.
        """
        self._check_open()
        on_failure = partial(self._record_failure, f"timer of {timer_period_sec:g} s", "it continues")
        timer = Timer(timer_period_sec, callback, self.graph.clock, on_failure)
        self._tasks.start(timer.run)
        return timer

    def create_task(self, function: Callable[[], Coroutine[object, object, None]]) -> None:
        """Run *function* as a task of the node, from now or from the node's start, until the node ends."""
        self._check_open()
        self._tasks.start(function)

    def declare_parameter(self, name: str, value: Value, descriptor: ParameterDescriptor | None = None) -> Parameter:
        """Declare a parameter with its default; see :meth:`homebot.graph.ParameterSet.declare`."""
        return self.parameters.declare(name, value, descriptor)

    def get_parameter(self, name: str) -> Parameter:
        """Return a declared parameter; see :meth:`homebot.graph.ParameterSet.get`."""
        return self.parameters.get(name)

    def get_logger(self) -> FilteringBoundLogger:
        """Return :attr:`log`."""
        return self.log

    def add_entity(self, entity: GraphEntity) -> None:
        """Show *entity* on the graph; it closes with the node."""
        self._entities[id(entity)] = entity
        self.graph.add_endpoint(entity, entity.info)

    def remove_entity(self, entity: GraphEntity) -> None:
        """Remove a closed *entity* from the graph. Idempotent."""
        if self._entities.pop(id(entity), None) is not None and isinstance(entity, Subscription):
            self.graph.failures.messages_lost += entity.losses
        self.graph.remove_endpoint(entity)

    def resolve_name(self, name: str, kind: str = "topic name") -> str:
        """Return the full name to which *name* expands in this node."""
        return expand_name(name, self.name, self.namespace, kind)

    @property
    def entities(self) -> tuple[GraphEntity, ...]:
        """Its open publishers, subscriptions, services and actions."""
        return tuple(self._entities.values())

    @property
    def is_closed(self) -> bool:
        """True if the node has left the graph."""
        return self._closed

    def close(self) -> None:
        """Close all entities of the node, leave the graph and end the tasks.

        The body of an enclosing ``async with node`` continues. Idempotent.
        """
        if self._closed:
            return
        self._closed = True
        for entity in reversed(list(self._entities.values())):
            entity.close()
        self.graph.remove_node(self)
        self._tasks.cancel()

    async def __aenter__(self) -> Self:
        self._check_open()
        await self._tasks.enter()
        return self

    async def __aexit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> bool | None:
        if not self._tasks.are_running:
            return None
        try:
            return await self._tasks.exit(exc_type, exc, traceback)
        finally:
            self.close()

    def _leave_topic(self, channel: Topic, end: Publisher[Any] | Subscription[Any]) -> None:
        channel.remove(end)
        self.graph.release_topic(channel)
        self.remove_entity(end)

    def _leave_service(self, slot: ServiceSlot, end: Service[Any, Any] | Client[Any, Any]) -> None:
        if end is slot.server:
            slot.set_server(None)
        self.graph.release_service_slot(slot)
        self.remove_entity(end)

    def _withdraw(self, offered: OfferedEntity) -> None:
        self.graph.withdraw(offered)
        self.remove_entity(offered)

    def _cancel_handlers(self) -> None:
        entities = self.entities
        for entity in entities:
            if entity.info.kind in _ACTION_ENDS:
                entity.close()  # first, so that callers that wait for results receive them
        for entity in entities:
            if isinstance(entity, Service) and not entity.is_closed:
                entity.cancel_handlers()

    def _record_failure(self, callback: str, cost: str, error: BaseException) -> None:
        if isinstance(error, asyncio.CancelledError):
            uncancel()
        crash = crash_of(self.full_name, error)
        if self._closed and isinstance(crash, ClosedError):
            return  # the node was closed meanwhile
        self.graph.failures.record(self.full_name, callback, crash, cost)

    def _record_check_failure(self, name: str, error: Exception) -> None:
        self.graph.failures.record(self.full_name, f"check of parameter {name}", error, "the value is refused")

    def _offer_parameters(self) -> None:
        for name, ros_type in PARAMETER_SERVICES.items():
            self.offer_service(ros_type, f"~/{name}", partial(self._serve_parameters, name))

    def _serve_parameters(self, name: str) -> None:
        from homebot.graph.parameter_services import parameter_service  # noqa: PLC0415 - few runs are asked

        service_type, handle = parameter_service(self.parameters, name)
        self.create_service(service_type, f"~/{name}", handle)

    def _announce_parameters(self, kind: Literal["new", "changed"], parameters: Sequence[Parameter]) -> None:
        messages = tuple(parameter.to_message() for parameter in parameters)
        self._events.publish(
            ParameterEvent(
                stamp=Time.from_seconds(self.graph.clock.now()),
                node=self.full_name,
                new_parameters=messages if kind == "new" else (),
                changed_parameters=messages if kind == "changed" else (),
                deleted_parameters=(),
            )
        )

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(f"the node {self.full_name} is closed")
