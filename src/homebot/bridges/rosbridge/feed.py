"""One topic on its way to one client.

Messages wait in the subscription's own queue until the client can take them: a slow client loses its oldest messages,
counted, and holds up nobody.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable

import anyio

from homebot.bridges.rosbridge.protocol import Identifier, Subscribe, publish_frame
from homebot.errors import ClosedError, LinkError
from homebot.graph import DurabilityPolicy, EntityKind, Graph, Node, QoSProfile, ReliabilityPolicy
from homebot.messages.json import JsonObject, message_to_json
from homebot.messages.message import Message

__all__ = ["Feed"]

_TURN = 64  # messages sent before other tasks get their turn, should the client keep up


class Feed:
    """Sends the messages of one topic to one client, once each, however often the client asked for the topic.

    Args:
        node: The node that subscribes in the client's stead.
        topic: The name that the client uses.
        message_type: What the topic carries.
        depth: Messages that may wait.
        send: Takes a frame to the client, waiting until there is room for it.

    Attributes:
        requests: The client's requests by their ids.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        message_type: type[Message],
        depth: int,
        send: Callable[[JsonObject], Awaitable[None]],
    ) -> None:
        self.requests: dict[Identifier, Subscribe] = {}
        self._node = node
        self._topic = topic
        self._message_type = message_type
        self._send = send
        self._qos = _fitting_qos(node.graph, node.resolve_name(topic), depth)
        self._subscription = node.create_subscription(message_type, topic, qos_profile=self._qos)
        self._scope = anyio.CancelScope()

    @property
    def lost(self) -> int:
        """Messages dropped because the client was too slow."""
        return self._subscription.lost

    def add(self, op: Subscribe) -> None:
        """Take one more request of the client; it gets what the publishers keep for late joiners."""
        is_first = not self.requests
        self.requests[op.id] = op
        if not is_first and self._qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            late = self._node.create_subscription(self._message_type, self._topic, qos_profile=self._qos)
            late.close()
            while (kept := late.take()) is not None:
                self._subscription.mailbox.put(kept)

    async def run(self) -> None:
        """Send until :meth:`close`, or until the client is gone."""
        with self._scope:
            try:
                await self._run()
            except (ClosedError, LinkError):
                return

    def close(self) -> None:
        """Leave the topic; nothing more is sent. Twice is fine."""
        self._subscription.close()
        self._scope.cancel()

    async def _run(self) -> None:
        told, sent = 0, 0
        while True:
            message = await self._subscription.receive()
            lost, told = self.lost - told, self.lost
            await self._send(publish_frame(self._topic, message_to_json(message), lost))
            sent += 1
            if throttle := min(op.throttle_rate for op in self.requests.values()):
                await anyio.sleep(throttle / 1000)
                self._drop_throttled()
            elif sent % _TURN == 0:
                await anyio.lowlevel.checkpoint()

    def _drop_throttled(self) -> None:
        """Drop what came while throttled, save the newest ``queue_length`` messages; that is no loss but a wish."""
        keep = max(op.queue_length for op in self.requests.values())
        while len(self._subscription.mailbox.queue) > keep:
            self._subscription.mailbox.take()


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
