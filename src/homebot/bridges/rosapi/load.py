"""A service of our own: the load of the graph, measured only while a client asks."""

import asyncio
import math
from collections.abc import Iterator
from typing import Final, final

from homebot.graph import Node, Publisher, Subscription
from homebot.messages.message import Message, ServiceType

_TICK: Final = 0.05
"""Seconds between two looks at the lag of the loop."""

_LASTS: Final = 10.0
"""Seconds after the last question for which handlers and the loop are measured."""


class TopicLoad(Message):
    """One topic.

    Attributes:
        published: Messages that its present publishers have published.
    """

    topic: str
    published: int = 0


class QueueLoad(Message):
    """The queue of one subscription, and its handler.

    Attributes:
        lost: Messages that were lost or expired in it, if it is to have all.
        slowest: Seconds that its handler needed at most since the question before, waiting included; 0 for none.
    """

    node: str
    topic: str
    waiting: int = 0
    lost: int = 0
    slowest: float = 0.0


class MeasureLoadRequest(Message):
    """A question for the load; the first one begins the measurement."""


class MeasureLoadResponse(Message):
    """The load at a moment.

    Attributes:
        at: The time of the monotonic clock, in seconds.
        lag: Seconds by which the event loop was late at most since the question before.
    """

    at: float
    lag: float = 0.0
    topics: tuple[TopicLoad, ...] = ()
    queues: tuple[QueueLoad, ...] = ()


MeasureLoad = ServiceType("homebot/srv/MeasureLoad", MeasureLoadRequest, MeasureLoadResponse)


def serve(node: Node) -> None:
    """Offer the service on *node*."""
    node.create_service(MeasureLoad, "/rosapi/load", LoadMeter(node).measure)


@final
class LoadMeter:
    """Measures the load of the graph of *node*."""

    def __init__(self, node: Node) -> None:
        self._graph = node.graph
        self._clock = node.graph.clock
        self._node = node
        self._lag = 0.0
        self._until = -math.inf

    def measure(self, _request: MeasureLoadRequest) -> MeasureLoadResponse:
        """Return the load since the question before."""
        now = self._clock.monotonic()
        if self._until < now:
            self._node.create_task(self._watch_loop)
        self._until = now + _LASTS
        published: dict[str, int] = {}
        queues = []
        for end in self._ends():
            if isinstance(end, Publisher):
                published[end.topic_name] = published.get(end.topic_name, 0) + end.published
                continue
            slowest, end.slowest = end.slowest or 0.0, 0.0
            waiting = len(end.mailbox.queue)
            queues.append(
                QueueLoad(node=end.info.node, topic=end.topic_name, waiting=waiting, lost=end.losses, slowest=slowest)
            )
        lag, self._lag = self._lag, 0.0
        topics = tuple(TopicLoad(topic=topic, published=count) for topic, count in published.items())
        return MeasureLoadResponse(at=now, lag=lag, topics=topics, queues=tuple(queues))

    async def _watch_loop(self) -> None:
        """Measure the lag of the loop until nobody has asked for some time; then measure nothing."""
        while (due := self._clock.monotonic() + _TICK) <= self._until:
            await asyncio.sleep(_TICK)
            self._lag = max(self._lag, self._clock.monotonic() - due)
        self._until = -math.inf
        for end in self._ends():
            if isinstance(end, Subscription):
                end.slowest = None

    def _ends(self) -> Iterator[Publisher[Message] | Subscription[Message]]:
        for name in self._graph.get_node_names():
            node = self._graph.get_node(name)
            for entity in () if node is None else node.entities:
                if isinstance(entity, Publisher | Subscription):
                    yield entity
