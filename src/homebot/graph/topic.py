"""One topic: its publishers, its subscriptions, and their QoS matching."""

from typing import Any

from homebot.errors import TypeMismatchError
from homebot.graph.publisher import Publisher
from homebot.graph.qos import DurabilityPolicy, qos_incompatibilities
from homebot.graph.subscription import OTHERS, Subscription
from homebot.log import LogLimit
from homebot.messages.message import Message
from homebot.support.logger import get_logger

_log = get_logger()

QOS_INCOMPATIBLE = "graph.qos_incompatible"


class Topic:
    """A named channel of one message type; it exists while it has publishers or subscriptions."""

    def __init__(self, name: str, message_type: type[Message], limit: LogLimit) -> None:
        """Create an unused topic; *limit* bounds the log lines about mismatches."""
        self._limit = limit
        self.name = name
        self.message_type = message_type
        self.publishers: list[Publisher[Any]] = []
        self.subscriptions: list[Subscription[Any]] = []

    @property
    def is_unused(self) -> bool:
        """True without publishers and subscriptions."""
        return not self.publishers and not self.subscriptions

    def check_type(self, message_type: type[Message], node: str) -> None:
        """Refuse a second type on the topic."""
        if message_type is not self.message_type:
            raise TypeMismatchError(
                f"{node} uses {self.name} with {message_type.ros_type}, but it carries {self.message_type.ros_type}"
            )

    def add_publisher(self, publisher: Publisher[Any]) -> None:
        """Connect *publisher* with every matching subscription."""
        self.publishers.append(publisher)
        for subscription in self.subscriptions:
            if _is_wanted(publisher, subscription):
                self._report_mismatch(publisher, subscription)
        publisher.connect(tuple(subscription for subscription in self.subscriptions if _fit(publisher, subscription)))

    def add_subscription(self, subscription: Subscription[Any]) -> None:
        """Connect *subscription* with every matching publisher and replay their history."""
        self.subscriptions.append(subscription)
        subscription.matched_ends = lambda: [
            publisher for publisher in self.publishers if _fit(publisher, subscription)
        ]
        for publisher in self.publishers:
            if not _is_wanted(publisher, subscription) or self._report_mismatch(publisher, subscription):
                continue
            if subscription.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
                publisher.replay(subscription)
            publisher.connect((*publisher.matched_ends(), subscription))

    def remove(self, end: Publisher[Any] | Subscription[Any]) -> None:
        """Disconnect one of its ends."""
        if isinstance(end, Publisher):
            self.publishers.remove(end)
            end.connect(())
            return
        self.subscriptions.remove(end)
        end.matched_ends = tuple
        for publisher in self.publishers:
            publisher.connect(tuple(matched_end for matched_end in publisher.matched_ends() if matched_end is not end))

    def _report_mismatch(self, publisher: Publisher[Any], subscription: Subscription[Any]) -> bool:
        """Log a QoS mismatch for both ends; return whether there is one."""
        problems = qos_incompatibilities(publisher.qos, subscription.qos)
        if not problems:
            return False
        publisher.incompatible_qos_count += 1
        subscription.incompatible_qos_count += 1
        held_back = self._limit.allows(f"{self.name} {publisher.info.node} {subscription.info.node}")
        if held_back is None:
            return True
        for end, other in ((publisher.info, subscription.info), (subscription.info, publisher.info)):
            _log.warning(
                QOS_INCOMPATIBLE,
                node=end.node,
                topic=self.name,
                end=end.kind.value,
                other_node=other.node,
                problem="; ".join(problems),
                consequence="no messages pass between them",
                held_back=held_back,
            )
        return True


def _fit(publisher: Publisher[Any], subscription: Subscription[Any]) -> bool:
    return _is_wanted(publisher, subscription) and not qos_incompatibilities(publisher.qos, subscription.qos)


def _is_wanted(publisher: Publisher[Any], subscription: Subscription[Any]) -> bool:
    node, wanted = publisher.info.node, subscription.from_node
    return node != subscription.info.node if wanted == OTHERS else wanted in {"", node}
