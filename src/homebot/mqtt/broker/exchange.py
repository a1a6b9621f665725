"""The router of published messages to subscriptions. No I/O."""

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple, final

from homebot.clock import Clock
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BULKY, BrokerMessage
from homebot.mqtt.broker.queue import REFUSED, TAKEN, DeliveryResult, QueuedMessage
from homebot.mqtt.broker.retained import Replay, RetainedMessages
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.session_subscription import SessionSubscription
from homebot.mqtt.broker.stats import Counters
from homebot.mqtt.broker.subscriptions import ShareGroup, SubscriptionTree, Target
from homebot.mqtt.packets import MqttSubscription, ReasonCode
from homebot.support.turn_budget import TurnBudget


class Receipt(NamedTuple):
    """The result of publishing a message.

    Attributes:
        reason: Success, 0x10 without subscribers, or 0x97 if a subscriber or the retained store had no room.
        slow: Connected sessions with long queues, for which the publisher should wait.
    """

    reason: ReasonCode
    slow: tuple[BrokerSession, ...] = ()


_GRANTED = (ReasonCode.SUCCESS, ReasonCode.GRANTED_QOS_1, ReasonCode.GRANTED_QOS_2)
_DELIVERED = Receipt(ReasonCode.SUCCESS)
_UNMATCHED = Receipt(ReasonCode.NO_MATCHING_SUBSCRIBERS)


@final
class MessageRouter:
    """Routes messages to subscriptions.

    Attributes:
        crowded: Connected sessions whose queue was three quarters full, until it is half empty.
        ended: Ended sessions that are not completely removed yet.
    """

    def __init__(
        self,
        clock: Clock,
        limits: BrokerLimits,
        counters: Counters,
        turn: TurnBudget,
        on_message: Callable[[BrokerMessage], None] | None = None,
    ) -> None:
        self._clock = clock
        self._limits = limits
        self._counters = counters
        self._on_message = on_message
        self._turn = turn
        self.subscriptions = SubscriptionTree()
        self.crowded: dict[BrokerSession, None] = {}
        self.ended: dict[BrokerSession, None] = {}
        self.retained = RetainedMessages(limits.max_retained_messages, limits.max_retained_bytes)

    def publish(self, message: BrokerMessage) -> Receipt:
        """Send *message* to all subscribers of its topic, and retain it if requested."""
        if self._on_message is not None:
            self._on_message(message)
        retained = not message.retain or self._retain(message)
        targets, groups = self.subscriptions.route(message.topic)
        slow: list[BrokerSession] = []
        large = message.size >= BULKY
        refused = bool(targets) and _deliver_to_all(targets, message, large, slow)
        for group in groups:
            chosen, outcome = _deliver_to_one(group, message, large)
            if outcome is REFUSED:
                refused = True
            elif chosen is not None and outcome:
                slow.append(chosen)
        if large or message.retain:
            message.forget_encoded()
        if refused or not retained:
            return Receipt(ReasonCode.QUOTA_EXCEEDED, tuple(slow))
        if slow:
            return Receipt(ReasonCode.SUCCESS, tuple(slow))
        return _DELIVERED if targets or groups else _UNMATCHED

    def without_room(self, topic: str) -> tuple[BrokerSession, ...]:
        """Return the connected sessions with a full queue that subscribe to *topic* at QoS 1 or 2."""
        if not self.crowded:
            return ()
        for session in [session for session in self.crowded if session.outbound is None or not session.backlogged]:
            del self.crowded[session]
        if not any(session.full for session in self.crowded):
            return ()
        route = self.subscriptions.route(topic)
        full = [target.session for target in route.targets if target.qos and target.session.full]
        for group in route.groups:
            connected = [session for session in group.members if session.outbound is not None]
            if all(session.full for session in connected):
                full += connected
        return tuple(full)

    def subscribe(
        self, session: BrokerSession, request: MqttSubscription, identifier: int, replay: Replay
    ) -> ReasonCode:
        """Add a subscription, replacing one with the same filter.

        Args:
            identifier: The subscription identifier; 0 is none.

        Returns:
            The granted QoS, 0x8F for too many levels, or 0x97 for too many subscriptions.
        """
        subscription = SessionSubscription.of(request, identifier)
        known = session.subscriptions.get(request.filter)
        levels = subscription.filter.count("/") + 1
        if levels > self._limits.max_topic_levels:
            return ReasonCode.TOPIC_FILTER_INVALID
        if known is None and not self._has_room(session, subscription, levels):
            self._counters.subscriptions_refused += 1
            return ReasonCode.QUOTA_EXCEEDED
        session.subscriptions[request.filter] = subscription
        self.subscriptions.add(session, subscription)
        if subscription.share is None and (
            request.retain_handling == 0 or (request.retain_handling == 1 and known is None)
        ):
            replay.add(subscription)
        return _GRANTED[request.qos]

    def unsubscribe(self, session: BrokerSession, name: str) -> ReasonCode:
        """Remove a subscription; return success, or 0x11 if there was none."""
        subscription = session.subscriptions.pop(name, None)
        if subscription is None:
            return ReasonCode.NO_SUBSCRIPTION_EXISTED
        self.subscriptions.remove(session, subscription)
        return ReasonCode.SUCCESS

    def forget(self, session: BrokerSession) -> None:
        """Remove an ended session; its unfinished shared messages go to others of the group.

        It gets nothing more; large numbers of subscriptions and messages are removed later, a few at a time.
        """
        self.crowded.pop(session, None)
        session.has_ended = True
        self.subscriptions.forget_routes()
        for name in [name for name, subscription in session.subscriptions.items() if subscription.share is not None]:
            self.unsubscribe(session, name)
        self.ended[session] = None
        self._turn.run(self._remove(session))

    def _remove(self, session: BrokerSession) -> Iterator[None]:
        """Remove the subscriptions of an ended session and deliver its shared messages to others, one in each step."""
        while session.subscriptions:
            _, subscription = session.subscriptions.popitem()
            self.subscriptions.remove(session, subscription)
            yield
        for message, qos, _, _, share in session.unsent():
            group = None if share is None or not qos else self.subscriptions.group(share)
            if group is not None:
                _deliver_to_one(group, message, message.size >= BULKY)
            yield
        del self.ended[session]

    def _retain(self, message: BrokerMessage) -> bool:
        if self.retained.store(message, self._clock.monotonic()):
            return True
        self._counters.retained_refused += 1
        return False

    def _has_room(self, session: BrokerSession, subscription: SessionSubscription, levels: int) -> bool:
        limits, tree = self._limits, self.subscriptions
        return (
            len(session.subscriptions) < limits.max_subscriptions
            and len(tree) < limits.max_all_subscriptions
            and tree.levels + levels <= limits.max_filter_levels
            and tree.text + len(subscription.name) <= limits.max_filter_text
            and (subscription.share is None or tree.shared < limits.max_shared_subscriptions)
        )


def _deliver_to_all(
    targets: Iterable[Target],
    message: BrokerMessage,
    large: bool,  # noqa: FBT001 - for every message, by position for speed
    slow: list[BrokerSession],
) -> bool:
    """Deliver to *targets*; True if one refused it. Those that took it but want no more for now go to *slow*.

    Receivers with the same options share one QueuedMessage.
    """
    refused = False
    highest = message.qos
    queued: QueuedMessage | None = None
    for target in targets:
        session, qos, retain, identifiers, matched = target
        if matched and session.client_id == message.origin:
            rest = target.without_local()
            if rest is None:
                continue
            _, qos, retain, identifiers, _ = rest
        if qos > highest:
            qos = highest
        retain = retain and message.retain
        if queued is None or queued[1] != qos or queued[2] is not retain or queued[3] is not identifiers:
            queued = QueuedMessage(message, qos, retain, identifiers)
        outcome = session.deliver_large(queued) if large else session.deliver(queued)
        if outcome is REFUSED:
            refused = True
        elif outcome is not TAKEN:
            slow.append(session)
    return refused


def _deliver_to_one(
    group: ShareGroup,
    message: BrokerMessage,
    large: bool,  # noqa: FBT001 - as above
) -> tuple[BrokerSession | None, DeliveryResult]:
    chosen = group.choose()
    if chosen is None:
        return None, TAKEN
    session, subscription = chosen
    identifiers = (subscription.identifier,) if subscription.identifier else ()
    retain = message.retain and subscription.retain_as_published
    queued = QueuedMessage(message, min(subscription.qos, message.qos), retain, identifiers, group.key)
    return session, session.deliver_large(queued) if large else session.deliver(queued)
