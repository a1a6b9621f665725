"""The topics that one client reads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from homebot.bridges.rosbridge.backlog import Backlog
from homebot.bridges.rosbridge.client import OutsideClient
from homebot.bridges.rosbridge.feed import Feed
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import Identifier, SubscribeOperation, TopicOperation
from homebot.bridges.rosbridge.types import message_type_of_topic
from homebot.errors import HomebotError, PeerError

__all__ = ["Subscriptions"]


class Subscriptions:
    """The topics that one client subscribed to, under the names that the client uses.

    A request for a topic of unknown type is remembered and served when the topic is first used.

    Args:
        on_unfit: Called with the operation, topic, reason and id where a remembered one cannot be served after all.
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
        """Return the number of requests: each id of each topic counts."""
        return sum(map(len, self._early.values())) + sum(len(feed.requests) for feed in self._feeds.values())

    def subscribe(self, op: SubscribeOperation) -> tuple[Literal["warning", "error"], str] | None:
        """Begin to send a topic; where its type is not known yet, return how bad that is and why.

        An unknown type is an error and a missing one a warning; in both cases messages come as soon as the topic
        is used.
        """
        full_name = self._node.resolve_name(op.topic)
        is_absent = self._node.graph.get_message_type(full_name) is None
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
        for key in early:
            if op.id in {None, key[1]}:
                del self._early[full_name][key]
        if early and not self._early[full_name]:
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
