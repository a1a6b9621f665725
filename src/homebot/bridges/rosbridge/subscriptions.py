"""The topics that one client reads.

Messages wait in a queue of the client's backlog until it reads them: a slow client loses messages, which are counted,
and delays no other client.
"""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from homebot.bridges.rosbridge import binary_frames
from homebot.bridges.rosbridge.access import right_to_publish
from homebot.bridges.rosbridge.backlog import Backlog, FeedQueue
from homebot.bridges.rosbridge.client import OutsideClient
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    Identifier,
    SubscribeOperation,
    TopicOperation,
    publish_frame,
)
from homebot.bridges.rosbridge.types import message_type_of_topic
from homebot.errors import HomebotError, PeerError
from homebot.graph import DurabilityPolicy, EntityKind, Node, QoSProfile, ReliabilityPolicy
from homebot.graph.subscription import key_of
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message
from homebot.rights import Right

_BINARY = frozenset({"cbor", "cbor-raw"})


class Subscriptions:
    """The subscriptions of one client, under the names that it uses.

    A request for a topic of unknown type is remembered and served when the topic is first used.

    Args:
        on_unfit: Called with operation, topic, reason and id if a remembered request cannot be served after all.
    """

    def __init__(
        self,
        client: OutsideClient,
        backlog: Backlog,
        outbox: Outbox,
        on_unfit: Callable[[str, str, str, Identifier], None],
    ) -> None:
        self._node, self._expected = client.shared.node, client.shared.expected
        self._depth = client.shared.settings.queue_depth
        self._backlog, self._outbox, self._on_unfit = backlog, outbox, on_unfit
        self._feeds: dict[str, Feed] = {}
        self._early: dict[str, dict[tuple[str, Identifier], SubscribeOperation]] = {}  # by full name

    def __len__(self) -> int:
        """Return the number of ids of all topics."""
        return sum(map(len, self._early.values())) + sum(len(feed.requests) for feed in self._feeds.values())

    def subscribe(self, op: SubscribeOperation) -> tuple[Literal["warning", "error"], str] | None:
        """Start sending a topic; if its type is not known yet, return the level and text of a remark.

        An unknown type is an error and a missing one a warning; in both cases messages are sent once the topic
        is used.
        """
        full_name = self._node.resolve_name(op.topic)
        is_absent = self._node.graph.get_message_type(full_name) is None
        if is_absent and right_to_publish(full_name) is Right.RAW:
            op = op.model_copy(update={"type": ""})  # homebot could not use its topic if a reader had typed it first
        try:
            self._serve(op)
        except PeerError as exc:
            if not is_absent:
                raise
            self._early.setdefault(full_name, {})[op.topic, op.id] = op
            self._expected.expect(full_name, self._topic_came)
            return "error" if op.type else "warning", f"{exc}; messages will come once somebody uses {full_name}"
        return None

    def unsubscribe(self, op: TopicOperation) -> None:
        """Stop sending a topic."""
        full_name, feed = self._node.resolve_name(op.topic), self._feeds.get(op.topic)
        early = [key for key in self._early.get(full_name, ()) if key[0] == op.topic]
        if not early and feed is None:
            raise PeerError(f"topic {op.topic} was not subscribed to by this client")
        if early:
            keys = [key for key in early if op.id in {None, key[1]}]
            for key in keys:
                del self._early[full_name][key]
            if not self._early[full_name]:
                self._forget_early(full_name)
        if feed is not None:
            feed.requests.pop(op.id, None)
            if op.id is None or not feed.requests:
                self._feeds.pop(op.topic).close()

    def close_one(self) -> bool:
        """Stop sending one topic; return whether there was one."""
        if self._early:
            self._forget_early(next(iter(self._early)))
        elif self._feeds:
            self._feeds.popitem()[1].close()
        else:
            return False
        return True

    def _serve(self, op: SubscribeOperation) -> None:
        message_type = message_type_of_topic(self._node.graph, self._node.resolve_name(op.topic), op.type)
        feed = self._feeds.get(op.topic)
        if feed is None:
            feed = Feed(self._node, op.topic, message_type, self._depth, self._backlog, self._outbox)
            self._feeds[op.topic] = feed
        feed.add(op)

    def _forget_early(self, full_name: str) -> None:
        del self._early[full_name]
        self._expected.forget(full_name, self._topic_came)

    def _topic_came(self, full_name: str) -> None:
        for op in self._early.pop(full_name, {}).values():
            try:
                self._serve(op)
            except HomebotError as exc:
                self._on_unfit(op.op, op.topic, str(exc), op.id)


class Feed:
    """The messages of one topic for one client, sent once however many requests there are."""

    def __init__(
        self, node: Node, topic: str, message_type: type[Message], depth: int, backlog: Backlog, outbox: Outbox
    ) -> None:
        self.requests: dict[Identifier, SubscribeOperation] = {}
        self._node = node
        self._topic = topic
        self._message_type = message_type
        self._outbox = outbox
        self._reported_losses = 0
        self._rest: asyncio.TimerHandle | None = None
        self._qos = QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)  # no send() waits for a client
        self._queue = FeedQueue(depth, key_of(message_type), backlog, self._on_arrival)
        self._subscription = node.create_subscription(message_type, topic, qos_profile=self._qos, queue=self._queue)

    @property
    def lost(self) -> int:
        """Messages dropped because the client was too slow."""
        return self._queue.lost

    def add(self, op: SubscribeOperation) -> None:
        """Add a request of the client, which gets the messages for late joiners, unless a publisher has none."""
        self.requests[op.id] = op
        node = self._node
        publishers = node.graph.get_endpoints(kind=EntityKind.PUBLISHER, name=node.resolve_name(self._topic))
        all_keep = all(
            publisher.qos and publisher.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL for publisher in publishers
        )
        if not publishers or not all_keep or op.qos.durability == "volatile":
            return
        depth = min(op.qos.depth or self._qos.depth, self._qos.depth)
        qos = replace(self._qos, depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        late = node.create_subscription(self._message_type, self._topic, qos_profile=qos)
        late.close()
        while (message := late.take()) is not None:
            self._queue.append(message)

    def next_frame(self) -> str | bytes | None:
        """Return the frame of the oldest waiting message, if any; the outbox asks again after other topics."""
        message = self._subscription.take()
        if message is None or not self.requests:
            return None
        lost, self._reported_losses = self.lost - self._reported_losses, self.lost
        if throttle := min(op.throttle_rate for op in self.requests.values()):
            self._rest = asyncio.get_running_loop().call_later(throttle / 1000, self._end_rest)
        elif len(self._queue):
            self._outbox.ready(self)
        asked = {op.compression for op in self.requests.values()}
        if asked.isdisjoint(_BINARY):
            return publish_frame(self._topic, message, lost)

        if "cbor-raw" in asked:
            now = Time.from_seconds(self._node.graph.clock.now())
            return binary_frames.publish_cbor_raw(self._topic, message, now, lost)
        return binary_frames.publish_cbor(self._topic, message, lost)

    def close(self) -> None:
        """Leave the topic, without sending anything more. Idempotent."""
        self.requests = {}
        self._queue.close()
        self._subscription.close()
        if self._rest is not None:
            self._rest.cancel()

    def _on_arrival(self) -> None:
        if self._rest is None:
            self._outbox.ready(self)

    def _end_rest(self) -> None:
        """Drop messages received while throttled, except the newest ``queue_length``: as requested, not a loss."""
        self._rest = None
        keep = max(op.qos.depth or op.queue_length for op in self.requests.values())
        while len(self._queue) > keep:
            self._queue.popleft()
        if len(self._queue):
            self._outbox.ready(self)
