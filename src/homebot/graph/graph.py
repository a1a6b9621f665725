"""The computation graph: every node, topic and service of the process, and a stream of changes.

It plays the role of the ROS master. A graph belongs to one event loop and is not thread-safe.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any

from homebot import messages
from homebot.clock import Clock, LoopClock
from homebot.errors import DuplicateNameError, TypeMismatchError
from homebot.graph.endpoint import ActionInfo, EndpointIndex, EndpointInfo, EntityKind, GraphChange, OfferedEntity
from homebot.graph.failures import Failures
from homebot.graph.mailbox import Mailbox
from homebot.graph.service import ServiceSlot
from homebot.graph.topic import Topic
from homebot.log import LogLimit
from homebot.messages.message import Message, ServiceType
from homebot.support.time_limits import TimeLimits

if TYPE_CHECKING:
    from homebot.graph.node import Node
    from homebot.messages.action import ActionType
    from homebot.messages.interfaces import Interfaces

WATCH_DEPTH = 10_000  # a house has a few thousand entities; after losses a watcher lists them again


class Graph:
    """A computation graph: the directory of its nodes, topics and services.

    Args:
        clock: The clock of nodes, timers and lifespans; by default that of the running loop. Timers sleep on the loop,
            so any other clock must run at its pace.

    Attributes:
        elsewhere: The entities of nodes of robots and other machines, as a link shows them; nobody here can use them.
        coming: The services that begin soon, by full name; until then who calls one may wait for it.
        call_limits: The time limits of the calls of all clients: one of a single call would leave its timer behind.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.elsewhere = EndpointIndex()
        self.coming = frozenset[str]()
        self.call_limits = TimeLimits()
        self.clock = clock or LoopClock()
        self._nodes: dict[str, Node] = {}
        self._topics: dict[str, Topic] = {}
        self._services: dict[str, ServiceSlot] = {}
        self._offered: dict[str, OfferedEntity] = {}
        self._endpoints = EndpointIndex()
        self._watchers: dict[tuple[EntityKind, str] | None, list[Mailbox[GraphChange]]] = {None: []}
        self._limit = LogLimit(self.clock)
        self.failures = Failures(self.clock)
        self._epoch = self.clock.now() - self.clock.monotonic()

    @cached_property
    def interfaces(self) -> Interfaces:
        """The interfaces that programs may name, by default those of ROS; loaded on first use."""
        return messages.Interfaces()

    def steady_now(self) -> float:
        """Return seconds since the Unix epoch, unaffected by clock changes since the graph was made.

        For numbers that must grow across restarts of a node, and of homebot unless the clock was set back meanwhile.
        """
        return self._epoch + self.clock.monotonic()

    def get_node_names(self) -> tuple[str, ...]:
        """Return the full names of all nodes, sorted."""
        return tuple(sorted(self._nodes))

    def get_node(self, name: str) -> Node | None:
        """Return the node with the full name *name*, if there is one."""
        return self._nodes.get(name)

    def get_topic_names_and_types(self) -> dict[str, str]:
        """Return the ROS type of every topic by its full name, sorted by name."""
        return {name: topic.message_type.ros_type for name, topic in sorted(self._topics.items())}

    def get_service_names_and_types(self) -> dict[str, str]:
        """Return the ROS type of every service that has a server, by its full name, sorted by name."""
        types = {name: slot.service_type.ros_type for name, slot in self._services.items() if slot.server}
        offered = (entity.info for entity in self._offered.values() if entity.info.kind is EntityKind.SERVICE)
        return dict(sorted((types | {info.name: info.ros_type for info in offered}).items()))

    def actions(self) -> tuple[ActionInfo, ...]:
        """Return all actions that have a server or a client, sorted by name."""
        kinds = (EntityKind.ACTION_SERVER, EntityKind.ACTION_CLIENT)
        servers, clients = (self._endpoints.find(kind, None, None) for kind in kinds)
        return tuple(
            ActionInfo(
                name,
                ros_type,
                tuple(info.node for info in servers if info.name == name),
                tuple(info.node for info in clients if info.name == name),
            )
            for name, ros_type in sorted({(info.name, info.ros_type) for info in (*servers, *clients)})
        )

    def get_action_names_and_types(self) -> dict[str, str]:
        """Return the ROS type of every action by its full name, sorted by name."""
        return {action.name: action.ros_type for action in self.actions()}

    def get_action_type(self, action: str) -> ActionType[Any, Any, Any] | None:  # any message types
        """Return the type of *action*, or None if it is unused."""
        service_type = self.get_service_type(f"{action}/_action/send_goal")
        return getattr(service_type, "action_type", None)

    def get_message_type(self, topic: str) -> type[Message] | None:
        """Return the message type of *topic*, or None if it is unused."""
        known = self._topics.get(topic)
        return known.message_type if known else None

    def get_service_type(self, service: str) -> ServiceType[Any, Any] | None:  # any message types
        """Return the type of *service*, or None if it is unused."""
        self._start_offered(service)
        slot = self._services.get(service)
        return slot.service_type if slot else None

    def get_endpoints(
        self, *, kind: EntityKind | None = None, name: str | None = None, node: str | None = None
    ) -> tuple[EndpointInfo, ...]:
        """Return the entities of one *kind*, under one full *name*, and of one *node*; None means any."""
        return self._endpoints.find(kind, name, node)

    def count_endpoints(self, node: str) -> int:
        """Return how many entities the node with the full name *node* has, itself included."""
        return self._endpoints.count_of(node)

    def get_message_types(self) -> tuple[type[Message], ...]:
        """Return the message types of all topics, each once. Cost: O(types)."""
        firsts = map(self._endpoints.first_of_each_type, (EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION))
        topics = (self._topics.get(endpoint.name) for endpoint in chain.from_iterable(firsts))
        return tuple(dict.fromkeys(topic.message_type for topic in topics if topic is not None))

    def get_service_types(self, fits: Callable[[str], bool]) -> tuple[ServiceType[Any, Any], ...]:  # as above
        """Return the types of served services whose full name *fits*, each once. Cost: O(types)."""
        firsts = self._endpoints.first_of_each_type(EntityKind.SERVICE)
        types = [self.get_service_type(endpoint.name) for endpoint in firsts if fits(endpoint.ros_type)]
        return tuple(service_type for service_type in types if service_type is not None)

    def get_topics_of_type(self, ros_type: str) -> tuple[str, ...]:
        """Return the full names of the topics that carry the type with the full name *ros_type*, sorted."""
        kinds = (EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION)
        return tuple(sorted({info.name for kind in kinds for info in self._endpoints.of_type(kind, ros_type)}))

    def get_services_of_type(self, ros_type: str) -> tuple[EndpointInfo, ...]:
        """Return the servers of services of type *ros_type*, sorted by service."""
        return tuple(sorted(self._endpoints.of_type(EntityKind.SERVICE, ros_type), key=lambda info: info.name))

    def handlers_without_caller(self) -> Iterator[tuple[str, float]]:
        """Yield services with handlers that run without a caller, and the age of the oldest in seconds."""
        for name, slot in sorted(self._services.items()):
            if slot.server is not None and (seconds := slot.server.seconds_without_caller()):
                yield name, seconds

    @contextmanager
    def watch(
        self, depth: int = WATCH_DEPTH, only: tuple[EntityKind, str] | None = None
    ) -> Iterator[Mailbox[GraphChange]]:
        """Stream every change from now on: ``with graph.watch() as changes: async for change in changes``.

        At most *depth* changes are queued; beyond this the oldest is dropped and counted in ``changes.lost``.

        Args:
            only: The kind and full name of the entities whose changes are wanted; None for all, which costs more.
        """
        changes: Mailbox[GraphChange] = Mailbox(depth)
        watchers = self._watchers.setdefault(only, [])
        watchers.append(changes)
        try:
            yield changes
        finally:
            watchers.remove(changes)
            if only is not None and not watchers:
                self._watchers.pop(only, None)
            changes.close()

    # The methods below are for nodes: they raise TypeMismatchError or DuplicateNameError for a name in other use.

    async def watch_services(self, name: str = "") -> AsyncIterator[str | None]:
        """Yield the full name of each new service, or only *name*. Read it to its end, in one task.

        None means that any service may be new: at the start, and after lost changes.
        """
        with self.watch(only=(EntityKind.SERVICE, name) if name else None) as changes:
            yield None
            lost = 0
            async for change in changes:
                if changes.lost > lost:
                    lost = changes.lost
                    while changes.take() is not None:
                        pass
                    yield None
                elif change.change == "added" and change.entity.kind is EntityKind.SERVICE:
                    yield change.entity.name

    def add_node(self, node: Node) -> None:
        """Add *node*."""
        if node.full_name in self._nodes:
            raise DuplicateNameError(f"a node {node.full_name} is already running; give one of the two another name")
        self._nodes[node.full_name] = node
        self.add_endpoint(node, EndpointInfo(EntityKind.NODE, node.full_name, node.full_name))

    def remove_node(self, node: Node) -> None:
        """Remove *node*."""
        if self._nodes.get(node.full_name) is node:
            del self._nodes[node.full_name]
            self.remove_endpoint(node)

    def topic(self, name: str, message_type: type[Message], node: str) -> Topic:
        """Return the topic with the full name *name*, created on first use."""
        self._start_offered(name)
        topic = self._topics.get(name)
        if topic is None or topic.is_unused:
            topic = self._topics[name] = Topic(name, message_type, self._limit)
        topic.check_type(message_type, node)
        return topic

    def release_topic(self, topic: Topic) -> None:
        """Remove *topic* if it is unused."""
        if topic.is_unused and self._topics.get(topic.name) is topic:
            del self._topics[topic.name]

    def service_slot(self, name: str, service_type: ServiceType[Any, Any], node: str) -> ServiceSlot:
        """Return the service with the full name *name* for one more user."""
        offered = self._offered_at(name)
        if offered is not None and (
            offered.load is None or (offered.info.name == name and offered.info.ros_type != service_type.ros_type)
        ):
            offered.start()
        slot = self._services.setdefault(name, ServiceSlot(name, service_type))
        if slot.service_type is not service_type:
            raise TypeMismatchError(
                f"{node} uses {name} as {service_type.ros_type}, but it is a {slot.service_type.ros_type}"
            )
        slot.offered = offered
        slot.users += 1
        return slot

    def release_service_slot(self, slot: ServiceSlot) -> None:
        """Remove one user of *slot*, and the slot after its last user."""
        slot.users -= 1
        if slot.users == 0:
            self._services.pop(slot.name, None)

    def offer(self, offered: OfferedEntity) -> None:
        """Start *offered*, an action or a service, when it or a part of it is first used."""
        name, kind = offered.info.name, offered.info.kind
        if self._endpoints.find(kind, name, None):
            raise DuplicateNameError(f"the {kind.removesuffix(' server')} {name} is already served")
        self._offered[name] = offered

    async def begin(self, endpoint: str) -> None:
        """Create the server of the offered entity that is, or contains, *endpoint*, and load its modules in a thread.

        Otherwise the first use loads them, for which everything else waits.
        """
        if (offered := self._offered_at(endpoint)) is not None:
            await offered.begin()

    def withdraw(self, offered: OfferedEntity) -> None:
        """Remove *offered*. Idempotent."""
        if self._offered.get(offered.info.name) is offered:
            del self._offered[offered.info.name]

    def add_endpoint(self, entity: object, info: EndpointInfo) -> None:
        """Add *entity* as *info* and notify the watchers."""
        self._endpoints.add(entity, info)
        self._notify(GraphChange("added", info))

    def remove_endpoint(self, entity: object) -> None:
        """Remove *entity* and notify the watchers. Idempotent."""
        if (info := self._endpoints.remove(entity)) is not None:
            self._notify(GraphChange("removed", info))

    def _offered_at(self, endpoint: str) -> OfferedEntity | None:
        """Return the offered entity that is, or contains, *endpoint*."""
        return self._offered.get(endpoint.partition("/_action/")[0]) if self._offered else None

    def _start_offered(self, endpoint: str) -> None:
        if (offered := self._offered_at(endpoint)) is not None:
            offered.start()

    def _notify(self, change: GraphChange) -> None:
        for watcher in (*self._watchers[None], *self._watchers.get((change.entity.kind, change.entity.name), ())):
            watcher.put(change)
