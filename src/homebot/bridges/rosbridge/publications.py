"""The topics that one client publishes on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError, right_to_publish
from homebot.bridges.rosbridge.protocol import Advertise, Identifier, PublishOperation, Unadvertise
from homebot.bridges.rosbridge.recent_messages import RecentMessages, TopicHistory
from homebot.bridges.rosbridge.types import (
    message_from_client,
    message_type_of_topic,
    partial_message_from_client,
)
from homebot.devices.client_rights import Right
from homebot.errors import PeerError, TypeMismatchError
from homebot.graph import DurabilityPolicy, Node, Publisher, QoSProfile, qos_profile_latched
from homebot.messages.message import Message

__all__ = ["Publications"]

# As the original bridge: one offer that fits every request, and a client that subscribes a moment late misses nothing.
_QOS = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass(slots=True)
class _Publication:
    publisher: Publisher[Message]
    message_type: type[Message]
    history: TopicHistory | None
    """None of a latched topic."""

    ids: set[Identifier] = field(default_factory=set)


class Publications:
    """The topics that one client publishes, under the names that the client uses.

    Args:
        node: The node that publishes in the client's stead.
        access: The client's identity, used as the issuer of messages.
        on_unfit: Called with the request and the problem where a message turns out wrong when a reader comes.
    """

    def __init__(self, node: Node, access: ClientAccess, on_unfit: Callable[[PublishOperation, str], None]) -> None:
        self._node = node
        self._access = access
        self._on_unfit = on_unfit
        self._recent = RecentMessages(node.graph.clock)
        self._topics: dict[str, _Publication] = {}
        self._ids = 0

    def __len__(self) -> int:
        """Return the number of topics and ids: each id of each topic counts."""
        return len(self._topics) + self._ids

    def __contains__(self, topic: object) -> bool:
        return topic in self._topics

    def advertise(self, op: Advertise) -> None:
        """Take up a topic; once more under another id is fine.

        Raises:
            InvalidNameError: The name is illegal.
            TypeMismatchError: The topic carries another type.
            PeerError: The type is unknown.
        """
        publication = self._open(op.topic, op.type, latched=op.latch)
        self._ids += op.id is not None and op.id not in publication.ids
        publication.ids.add(op.id)

    def unadvertise(self, op: Unadvertise) -> None:
        """Give a topic up.

        Raises:
            PeerError: The client does not publish on it.
        """
        publication = self._topics.get(op.topic)
        if publication is None:
            raise PeerError(f"topic {op.topic} was not advertised by this client")
        self._ids -= op.id is not None and op.id in publication.ids
        publication.ids.discard(op.id)
        if op.id is None or not publication.ids:
            self._close(op.topic)

    def publish(self, op: PublishOperation, size: int) -> tuple[str, ...]:
        """Publish a message, which came in a frame of *size* characters, and return the fields that it lacked.

        A topic that exists need not be advertised. On homebot's own topics a message has to have all fields. Of a
        stream that nobody reads one message a second is checked.

        Raises:
            TypeMismatchError: The message does not fit the topic.
            PeerError: There is no such topic.
            MissingRightError: The message is of a robot that the client may not be.
        """
        publication = self._topics.get(op.topic)
        if publication is None:
            self._message(message_type_of_topic(self._node.graph, self._node.resolve_name(op.topic), ""), op)
            publication = self._open(op.topic, "", latched=op.latch)
        history = publication.history
        if history is not None and not publication.publisher.subscription_count and not history.is_due():
            self._recent.add(op, size)
            return ()
        message, missing = self._message(publication.message_type, op)
        if history is not None:
            self._recent.add(op, size)
        publication.publisher.publish(message)
        return missing

    def close_one(self) -> bool:
        """Give one topic up; return whether there was one."""
        if not self._topics:
            return False
        self._close(next(reversed(self._topics)))
        return True

    def _message(self, message_type: type[Message], op: PublishOperation) -> tuple[Message, tuple[str, ...]]:
        name, values = self._node.resolve_name(op.topic), self._access.stamped(message_type, op.msg)
        missing: tuple[str, ...] = ()
        try:
            message = message_from_client(message_type, values)
        except TypeMismatchError:
            if right_to_publish(name) is Right.RAW:
                raise
            message, missing = partial_message_from_client(message_type, values)
        self._access.check_robot(name, message)
        return message, missing

    def _close(self, topic: str) -> None:
        publication = self._topics.pop(topic)
        self._ids -= len(publication.ids - {None})
        publication.publisher.close()

    def _open(self, topic: str, ros_type: str, *, latched: bool) -> _Publication:
        message_type = message_type_of_topic(self._node.graph, self._node.resolve_name(topic), ros_type)
        present = self._topics.get(topic)
        if present is not None and (present.history is None or not latched):
            return present
        clock, read = self._node.graph.clock, partial(self._late_message, message_type)
        history = None if latched else TopicHistory(topic, self._recent, read, clock)
        qos = qos_profile_latched if latched else _QOS
        publisher = self._node.create_publisher(message_type, topic, qos, history=history)
        opened = _Publication(publisher, message_type, history, present.ids if present else set())
        if present is not None:
            present.publisher.close()
        self._topics[topic] = opened
        return opened

    def _late_message(self, message_type: type[Message], op: PublishOperation) -> Message | None:
        try:
            return self._message(message_type, op)[0]
        except (MissingRightError, TypeMismatchError) as exc:
            self._on_unfit(op, str(exc))
            return None
