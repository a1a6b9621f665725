"""One topic on its way to one client.

Messages wait in a queue of the client's backlog until the client can take them: a slow client loses messages, counted,
and delays no other client.
"""

from __future__ import annotations

import asyncio

from homebot.bridges.rosbridge import binary_frames
from homebot.bridges.rosbridge.backlog import Backlog, FeedQueue
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.packing import Packing
from homebot.bridges.rosbridge.protocol import Compression, Identifier, SubscribeOperation, publish_frame
from homebot.graph import DurabilityPolicy, EntityKind, Graph, Node, QoSProfile, ReliabilityPolicy
from homebot.graph.subscription import key_of
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["Feed"]

_BINARY: frozenset[Compression] = frozenset({"cbor", "cbor-raw"})


class Feed:
    """Sends the messages of one topic to one client, once each, however often the client asked for the topic."""

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
        self._qos = _fitting_qos(node.graph, node.resolve_name(topic), depth)
        self._queue = FeedQueue(depth, key_of(message_type), backlog, self._on_arrival)
        lost = backlog.everybody.lost
        self._subscription = node.create_subscription(message_type, topic, qos_profile=self._qos, queue=self._queue)
        self._queue.lost, backlog.everybody.lost = 0, lost  # to ask for less history than is kept is no loss

    @property
    def lost(self) -> int:
        """Messages dropped because the client was too slow."""
        return self._queue.lost

    @property
    def packing(self) -> Packing:
        """The form of messages that are text, in the shortest fragments that a request of the client asks for."""
        requests = self.requests.values()
        sizes = [op.fragment_size for op in requests if op.fragment_size is not None and op.fragment_size > 0]
        return Packing(any(op.compression == "png" for op in requests), min(sizes, default=0))

    def add(self, op: SubscribeOperation) -> None:
        """Add a request of the client; it receives the publishers' history for late joiners."""
        is_first = not self.requests
        self.requests[op.id] = op
        if not is_first and self._qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            late = self._node.create_subscription(self._message_type, self._topic, qos_profile=self._qos)
            late.close()
            while (kept := late.take()) is not None:
                self._queue.append(kept)

    def next_frame(self) -> str | bytes | None:
        """Return the frame of the oldest waiting message, if there is one; the outbox asks again after others' turn."""
        message = self._subscription.take()
        if message is None or not self.requests:
            return None
        lost, self._reported_losses = self.lost - self._reported_losses, self.lost
        if throttle := min(op.throttle_rate for op in self.requests.values()):
            self._rest = asyncio.get_running_loop().call_later(throttle / 1000, self._end_rest)
        elif len(self._queue):
            self._outbox.ready(self)
        return self._frame(message, lost)

    def close(self) -> None:
        """Leave the topic; nothing more is sent. Twice is fine."""
        self.requests = {}
        self._queue.close()
        self._subscription.close()
        if self._rest is not None:
            self._rest.cancel()

    def _frame(self, message: Message, lost: int) -> str | bytes:
        """Return the frame of *message* in the most compact form that a request of the client asks for."""
        asked = {op.compression for op in self.requests.values()}
        if asked.isdisjoint(_BINARY):
            return publish_frame(self._topic, message, lost)

        if "cbor-raw" in asked:
            now = Time.from_seconds(self._node.graph.clock.now())
            return binary_frames.publish_cbor_raw(self._topic, message, now, lost)
        return binary_frames.publish_cbor(self._topic, message, lost)

    def _on_arrival(self) -> None:
        if self._rest is None:
            self._outbox.ready(self)

    def _end_rest(self) -> None:
        """Drop messages received while throttled, except the newest ``queue_length``; that is requested, not a loss."""
        self._rest = None
        keep = max(op.queue_length for op in self.requests.values())
        while len(self._queue) > keep:
            self._queue.popleft()
        if len(self._queue):
            self._outbox.ready(self)


def _fitting_qos(graph: Graph, topic: str, depth: int) -> QoSProfile:
    """Return the request that every publisher of *topic* can serve.

    Late joiner's messages are asked for where all publishers keep some. Never RELIABLE: ``send()`` of a publisher waits
    for reliable readers, and must not wait for a program outside.
    """
    publishers = graph.get_endpoints(kind=EntityKind.PUBLISHER, name=topic)
    all_keep = all(info.qos and info.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL for info in publishers)
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if publishers and all_keep else DurabilityPolicy.VOLATILE,
    )
