"""The computation graph: every node, topic and service of the process, and a stream of what comes and goes.

It does the ROS master's job. One graph belongs to one event loop; nothing here may be called from another thread.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from homebot.clock import Clock, LoopClock
from homebot.errors import DuplicateNameError, TypeMismatchError
from homebot.graph.endpoint import EndpointIndex, EndpointInfo, EntityKind, GraphChange
from homebot.graph.failures import Failures
from homebot.graph.mailbox import Mailbox
from homebot.graph.service import ServiceSlot
from homebot.graph.service_counts import ServiceCounts
from homebot.graph.topic import Topic
from homebot.log import LogLimit
from homebot.messages.message import Message, ServiceType

if TYPE_CHECKING:
    from homebot.graph.node import Node

__all__ = ["Graph"]

WATCH_DEPTH = 10_000  # a house has some thousand entities; a watcher that is this far behind asks anew


class Graph:
    """A computation graph: the directory of its nodes, topics and services.

    Args:
        clock: The time that nodes, timers and lifespans go by; by default that of the running loop. Timers sleep on the
            loop, so another clock must run with it.

    Attributes:
        clock: That clock.
        failures: The exceptions that callbacks of its nodes let through.
        service_counts: What became of service calls that did not end as they should.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock = clock or LoopClock()
        self._nodes: dict[str, Node] = {}
        self._topics: dict[str, Topic] = {}
        self._services: dict[str, ServiceSlot] = {}
        self._endpoints = EndpointIndex()
        self._watchers: list[Mailbox[GraphChange]] = []
        self._limit = LogLimit(self.clock)
        self.failures = Failures(self.clock)
        self.service_counts = ServiceCounts(self.clock)
        self._epoch = self.clock.now() - self.clock.monotonic()

    def steady_now(self) -> float:
        """Return seconds since the Unix epoch, by the clock when the graph was made: setting it changes nothing.

        For numbers that must grow over restarts of a node, and of homebot too unless the clock was set back meanwhile.
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
        return {name: slot.service_type.ros_type for name, slot in sorted(self._services.items()) if slot.server}

    def get_message_type(self, topic: str) -> type[Message] | None:
        """Return what the topic with the full name *topic* carries, or None when nobody uses it."""
        found = self._topics.get(topic)
        return found.message_type if found else None

    def get_service_type(self, service: str) -> ServiceType[Any, Any] | None:  # either type may be any message
        """Return the type of the service with the full name *service*, or None when nobody uses it."""
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
        """Return what the topics carry, each type once; costs what there are of types, not of topics."""
        found: dict[type[Message], None] = {}
        for kind in (EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION):
            for ros_type in self._endpoints.types(kind):
                first = self._endpoints.first_of_type(kind, ros_type)
                topic = self._topics.get(first.name) if first else None
                if topic is not None:
                    found[topic.message_type] = None
        return tuple(found)

    def get_service_types(self) -> tuple[ServiceType[Any, Any], ...]:  # as above
        """Return the types of the services that have a server, each once; costs what there are of types."""
        first_endpoints = (
            self._endpoints.first_of_type(EntityKind.SERVICE, ros_type)
            for ros_type in self._endpoints.types(EntityKind.SERVICE)
        )
        return tuple(self._services[first.name].service_type for first in first_endpoints if first)

    def get_topics_of_type(self, ros_type: str) -> tuple[str, ...]:
        """Return the full names of the topics that carry the type with the full name *ros_type*, sorted."""
        kinds = (EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION)
        return tuple(sorted({info.name for kind in kinds for info in self._endpoints.of_type(kind, ros_type)}))

    def get_services_of_type(self, ros_type: str) -> tuple[EndpointInfo, ...]:
        """Return the servers whose service is of the type with the full name *ros_type*, sorted by service."""
        return tuple(sorted(self._endpoints.of_type(EntityKind.SERVICE, ros_type), key=lambda info: info.name))

    def handlers_without_caller(self) -> Iterator[tuple[str, float]]:
        """Yield the services with a handler at work whose caller has left, and the seconds since the oldest began."""
        for name, slot in sorted(self._services.items()):
            if slot.server is not None and (seconds := slot.server.seconds_without_caller()):
                yield name, seconds

    @contextmanager
    def watch(self) -> Iterator[Mailbox[GraphChange]]:
        """Give a stream of every change from now on: ``with graph.watch() as changes: async for change in changes``.

        10,000 changes may wait; then the oldest is dropped and counted in ``changes.lost``.
        """
        changes: Mailbox[GraphChange] = Mailbox(WATCH_DEPTH)
        self._watchers.append(changes)
        try:
            yield changes
        finally:
            self._watchers.remove(changes)
            changes.close()

    # What follows is for nodes.

    async def watch_services(self) -> AsyncIterator[str | None]:
        """Yield the full name of each service that comes, from the first step on; to be read to its end, in one task.

        None comes at the beginning, and whenever more happened than could be remembered: any service may be a new one.
        """
        with self.watch() as changes:
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
        """Take *node* in.

        Raises:
            DuplicateNameError: A node of this name is there.
        """
        if node.full_name in self._nodes:
            raise DuplicateNameError(f"a node {node.full_name} is already running; give one of the two another name")
        self._nodes[node.full_name] = node
        self.add_endpoint(node, EndpointInfo(EntityKind.NODE, node.full_name, node.full_name))

    def remove_node(self, node: Node) -> None:
        """Let *node* go."""
        if self._nodes.get(node.full_name) is node:
            del self._nodes[node.full_name]
            self.remove_endpoint(node)

    def topic(self, name: str, message_type: type[Message], node: str) -> Topic:
        """Return the topic with the full name *name*, made when it is new.

        Raises:
            TypeMismatchError: It carries another type.
        """
        topic = self._topics.get(name)
        if topic is None or topic.is_unused:
            topic = self._topics[name] = Topic(name, message_type, self._limit)
        topic.check_type(message_type, node)
        return topic

    def release_topic(self, topic: Topic) -> None:
        """Forget *topic* when nobody uses it."""
        if topic.is_unused and self._topics.get(topic.name) is topic:
            del self._topics[topic.name]

    def service_slot(self, name: str, service_type: ServiceType[Any, Any], node: str) -> ServiceSlot:
        """Return the service with the full name *name* for one more user.

        Raises:
            TypeMismatchError: It is of another type.
        """
        slot = self._services.setdefault(name, ServiceSlot(name, service_type))
        if slot.service_type is not service_type:
            raise TypeMismatchError(
                f"{node} uses {name} as {service_type.ros_type}, but it is a {slot.service_type.ros_type}"
            )
        slot.users += 1
        return slot

    def release_service_slot(self, slot: ServiceSlot) -> None:
        """Count one user less; the last one lets the name go."""
        slot.users -= 1
        if slot.users == 0:
            self._services.pop(slot.name, None)

    def add_endpoint(self, entity: object, info: EndpointInfo) -> None:
        """Show *entity* as *info* and notify the watchers."""
        self._endpoints.add(entity, info)
        self._notify(GraphChange("added", info))

    def remove_endpoint(self, entity: object) -> None:
        """Show *entity* no longer and notify the watchers. Twice is fine."""
        if (info := self._endpoints.remove(entity)) is not None:
            self._notify(GraphChange("removed", info))

    def _notify(self, change: GraphChange) -> None:
        for watcher in self._watchers:
            watcher.put(change)
