"""The topics that one client reads."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

import anyio
from anyio.abc import TaskGroup, TaskStatus

from homebot.bridges.rosbridge.feed import Feed
from homebot.bridges.rosbridge.protocol import Identifier, Subscribe, Unsubscribe
from homebot.bridges.rosbridge.types import message_type_of_topic
from homebot.errors import HomebotError, PeerError
from homebot.graph import EntityKind, Node
from homebot.messages.json import JsonObject

__all__ = ["Subscriptions"]


class Subscriptions:
    """What one client subscribed to; topics are kept under the names that the client uses.

    A request for a topic whose type cannot be told yet is remembered and served once somebody uses the topic.

    Args:
        node: The node that subscribes in the client's stead.
        depth: Messages of a topic that may wait for the client.
        send: Takes a frame to the client, waiting until there is room for it.
        tasks: Where the feeds run.
    """

    def __init__(self, node: Node, depth: int, send: Callable[[JsonObject], Awaitable[None]], tasks: TaskGroup) -> None:
        self._node = node
        self._depth = depth
        self._send = send
        self._tasks = tasks
        self._feeds: dict[str, Feed] = {}
        self._early: dict[str, dict[Identifier, Subscribe]] = {}
        self._watches = False

    def __len__(self) -> int:
        return len(self._feeds) + len(self._early)

    @property
    def lost(self) -> int:
        """Messages dropped because the client was too slow, on the topics it reads now."""
        return sum(feed.lost for feed in self._feeds.values())

    async def subscribe(self, op: Subscribe) -> str | None:
        """Begin to send a topic; where its type cannot be told yet, return that in words and begin once it can.

        Raises:
            InvalidNameError: The name is illegal.
            TypeMismatchError: The topic carries another type than the client expects.
        """
        full_name = self._node.resolve_name(op.topic)
        is_absent = self._node.graph.get_message_type(full_name) is None
        try:
            self._serve(op)
        except PeerError as exc:
            if not is_absent:
                raise
            self._early.setdefault(op.topic, {})[op.id] = op
            if not self._watches:
                self._watches = True
                await self._tasks.start(self._watch)
            return f"{exc}; messages will come once somebody publishes on it"
        return None

    def unsubscribe(self, op: Unsubscribe) -> None:
        """Stop sending a topic.

        Raises:
            PeerError: The client did not subscribe to it.
        """
        early, feed = self._early.get(op.topic), self._feeds.get(op.topic)
        if early is None and feed is None:
            raise PeerError(f"topic {op.topic} was not subscribed to by this client")
        if early is not None:
            early.pop(op.id, None)
            if op.id is None or not early:
                del self._early[op.topic]
        if feed is not None:
            remaining = {key: request for key, request in feed.requests.items() if key != op.id and op.id is not None}
            if remaining:
                feed.requests = remaining
            else:
                self._feeds.pop(op.topic).close()

    def close(self) -> None:
        """Stop sending anything."""
        self._early.clear()
        while self._feeds:
            self._feeds.popitem()[1].close()

    def _serve(self, op: Subscribe) -> None:
        message_type = message_type_of_topic(self._node.graph, self._node.resolve_name(op.topic), op.type)
        feed = self._feeds.get(op.topic)
        if feed is not None:
            feed.add(op)
            return
        feed = self._feeds[op.topic] = Feed(self._node, op.topic, message_type, self._depth, self._send)
        feed.add(op)
        self._tasks.start_soon(feed.run)

    async def _watch(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        with self._node.graph.watch() as changes:
            task_status.started()
            async for change in changes:
                if change.change == "added" and change.entity.kind in {EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION}:
                    self._serve_early(change.entity.name)

    def _serve_early(self, full_name: str) -> None:
        for topic in [topic for topic in self._early if self._node.resolve_name(topic) == full_name]:
            for op in self._early.pop(topic).values():
                try:
                    self._serve(op)
                except HomebotError as exc:
                    self._node.log.warning(
                        "door.late_topic_unfit",
                        message=f"nobody outside hears {full_name}: {exc}",
                        topic=full_name,
                        problem=str(exc),
                    )
