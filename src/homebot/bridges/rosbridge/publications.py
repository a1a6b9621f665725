"""The topics that one client publishes on."""

from __future__ import annotations

from dataclasses import dataclass, field

from homebot.bridges.rosbridge.protocol import Advertise, Identifier, Publish, Unadvertise
from homebot.bridges.rosbridge.types import message_type_of_topic
from homebot.bridges.rosbridge.values import message_from_client
from homebot.errors import PeerError
from homebot.graph import DurabilityPolicy, Node, Publisher, QoSProfile, qos_profile_latched
from homebot.messages.message import Message

__all__ = ["Publications"]

# As the original bridge: one offer that fits every request, and whoever subscribes a moment late misses nothing.
_QOS = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=1.0)


@dataclass(slots=True)
class _Publication:
    publisher: Publisher[Message]
    message_type: type[Message]
    ids: set[Identifier] = field(default_factory=set)
    latched: bool = False


class Publications:
    """What one client publishes; topics are kept under the names that the client uses.

    Args:
        node: The node that publishes in the client's stead.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._topics: dict[str, _Publication] = {}

    def __len__(self) -> int:
        return len(self._topics)

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
        publication.ids.add(op.id)

    def unadvertise(self, op: Unadvertise) -> None:
        """Give a topic up.

        Raises:
            PeerError: The client does not publish on it.
        """
        publication = self._topics.get(op.topic)
        if publication is None:
            raise PeerError(f"topic {op.topic} was not advertised by this client")
        publication.ids.discard(op.id)
        if op.id is None or not publication.ids:
            self._topics.pop(op.topic).publisher.close()

    def publish(self, op: Publish) -> None:
        """Publish a message; a topic that exists need not be advertised.

        Raises:
            TypeMismatchError: The message does not fit the topic.
            PeerError: There is no such topic.
        """
        publication = self._topics.get(op.topic)
        if publication is not None:
            publication.publisher.publish(message_from_client(publication.message_type, op.msg))
            return
        message_type = message_type_of_topic(self._node.graph, self._node.resolve_name(op.topic), "")
        message = message_from_client(message_type, op.msg)
        self._open(op.topic, "", latched=op.latch).publisher.publish(message)

    def close(self) -> None:
        """Give everything up."""
        while self._topics:
            self._topics.popitem()[1].publisher.close()

    def _open(self, topic: str, ros_type: str, *, latched: bool) -> _Publication:
        message_type = message_type_of_topic(self._node.graph, self._node.resolve_name(topic), ros_type)
        present = self._topics.get(topic)
        if present is not None and (present.latched or not latched):
            return present
        publisher = self._node.create_publisher(message_type, topic, qos_profile_latched if latched else _QOS)
        opened = _Publication(publisher, message_type, present.ids if present else set(), latched)
        if present is not None:
            present.publisher.close()
        self._topics[topic] = opened
        return opened
