"""The topics on which one client publishes."""

import math
import re
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

from homebot.bridges.rosbridge.access import MissingRightError, right_to_publish
from homebot.bridges.rosbridge.backlog import Backlog, FeedQueue
from homebot.bridges.rosbridge.client import OutsideClient
from homebot.bridges.rosbridge.protocol import (
    Advertise,
    FrameError,
    Identifier,
    PublishOperation,
    TopicOperation,
    parse_frame,
)
from homebot.bridges.rosbridge.types import (
    message_from_client,
    message_type_of_topic,
    partial_message_from_client,
)
from homebot.errors import PeerError, TypeMismatchError
from homebot.graph import DurabilityPolicy, Publisher, QoSProfile
from homebot.graph.subscription import key_of
from homebot.messages.message import Message
from homebot.rights import Right

# As in the original bridge: compatible with every request, and late subscribers miss nothing.
_QOS = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL)

_MAX_KEPT: Final = 100
"""Most messages of a topic kept for late subscribers; as many as tf2's listeners ask for of ``/tf_static``, where their
clients send one message after the other (geometry2, ``tf2_ros/qos.hpp``)."""

_PUBLISH: Final = re.compile(r'\{"op": ?"publish", ?(?:"id": ?"([^"\\]*)", ?)?"topic": ?"([^"\\]+)"')
"""The beginning of a message as most libraries write it, which has id and topic before the frame is parsed."""

_MAX_PARSED_CHARACTERS: Final = 65_536
"""Most characters of a frame that is parsed at once when a reader subscribes."""

_CHECKED: Final = 1
"""Unread messages of a topic that are checked per second, so that its client learns of mistakes."""


_MAX_REFUSED: Final = 100
"""Most topics whose messages are refused before they are parsed; those of others are refused after that."""

_RECENT: Final = 1.0
_MAX_RECENT: Final = 10
_MAX_CHARACTERS: Final = 1_048_576
"""Seconds and messages of one topic, and characters of all, kept for late subscribers; the newest message is always
kept."""


class _KeptMessage(NamedTuple):
    """A message as its client sent it, unchecked, because most streams have no reader."""

    at: float
    size: int
    topic: str
    message: PublishOperation | str


@dataclass(slots=True)
class _Publication:
    publisher: Publisher[Message]
    message_type: type[Message]
    kept: FeedQueue | None
    ids: set[Identifier] = field(default_factory=set)
    second: float = -math.inf
    checked: int = 0


class Publications:
    """The topics that one client publishes, under the names that the client uses.

    Args:
        on_unfit: Called with operation, topic, problem and id if a message turns out invalid for a late reader.
    """

    def __init__(self, client: OutsideClient, on_unfit: Callable[[str, str, str, Identifier], None]) -> None:
        self._node, self._access, self._on_unfit = client.shared.node, client.access, on_unfit
        self._advertised = client.shared.advertised
        self._kept = Backlog(client.shared.settings.max_kept_bytes_of_all, client.shared.kept)
        self._now = self._node.graph.clock.monotonic
        self._recent: deque[_KeptMessage] = deque()
        self._recent_size = 0
        self._topics: dict[str, _Publication] = {}
        self._refused: set[str] = set()

    def __len__(self) -> int:
        """Return the number of ids of all topics."""
        return sum(1 + len(advertised.ids - {None}) for advertised in self._topics.values())

    def __contains__(self, topic: object) -> bool:
        return topic in self._topics

    def advertise(self, op: Advertise) -> None:
        """Add a topic; it may be added again under another id."""
        self._open(op.topic, op.type, op.kept).ids.add(op.id)
        self._advertised[op.topic] = op.type

    def unadvertise(self, op: TopicOperation) -> None:
        """Remove a topic."""
        publication = self._topics.get(op.topic)
        if publication is None:
            raise PeerError(f"topic {op.topic} was not advertised by this client")
        publication.ids.discard(op.id)
        if op.id is None or not publication.ids:
            self._close(op.topic)

    def publish(self, op: PublishOperation, size: int) -> tuple[str, ...]:
        """Publish a message from a frame of *size* characters, and return its missing fields.

        Existing topics need not be advertised. On homebot's own topics all fields are required. Of a stream without
        readers one message a second is checked.
        """
        publication = self._topics.get(op.topic)
        if publication is None:
            name = self._node.resolve_name(op.topic)
            is_absent = self._node.graph.get_message_type(name) is None
            ros_type = op.type or (self._advertised.get(op.topic, "") if is_absent else "")
            self._message(message_type_of_topic(self._node.graph, name, ros_type), op)
            publication = self._open(op.topic, ros_type, op.kept)
        if self._is_unread(publication):
            self._store(op.topic, op, size)
            return ()
        if self._now() >= publication.second + 1.0:
            publication.second, publication.checked = self._now(), 0
        publication.checked += 1
        message, missing = self._message(publication.message_type, op)
        if publication.kept is None:
            self._store(op.topic, op, size)
        publication.publisher.publish(message)
        return missing

    def store_unread(self, frame: str) -> bool:
        """Store *frame* unparsed if it is a message on a topic without readers; return whether it is."""
        begin = _PUBLISH.match(frame)
        publication = self._topics.get(begin[2]) if begin is not None and len(frame) <= _MAX_PARSED_CHARACTERS else None
        if begin is None or publication is None or not self._is_unread(publication):
            return False
        self._store(begin[2], frame, len(frame))
        return True

    def refused_before(self, frame: str) -> PublishOperation | None:
        """Return the operation of an unparsed *frame*, without its message, if its topic was refused before."""
        begin = _PUBLISH.match(frame) if self._refused else None
        if begin is None or begin[2] not in self._refused:
            return None
        return PublishOperation(op="publish", id=begin[1], topic=begin[2], msg={})

    def record_refused(self, topic: str) -> None:
        """Record that the client has no right to publish on *topic*."""
        if len(self._refused) < _MAX_REFUSED:
            self._refused.add(topic)

    def close_one(self) -> bool:
        """Remove one topic; return whether there was one."""
        if not self._topics:
            self._kept.close()
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
            message, missing = partial_message_from_client(message_type, values, self._node.graph.clock.now())
        self._access.check_robot(name, message)
        return message, missing

    def _close(self, topic: str) -> None:
        publication = self._topics.pop(topic)
        publication.publisher.close()
        if publication.kept is not None:
            publication.kept.close()

    def _is_unread(self, publication: _Publication) -> bool:
        """Return whether *publication* has no readers, and enough messages were checked within this second."""
        is_read = publication.kept is not None or publication.publisher.subscription_count
        return not is_read and publication.checked >= _CHECKED and self._now() < publication.second + 1.0

    def _open(self, topic: str, ros_type: str, kept: int) -> _Publication:
        message_type = message_type_of_topic(self._node.graph, self._node.resolve_name(topic), ros_type)
        present = self._topics.get(topic)
        if present is not None and (present.kept is not None or not kept):
            return present
        queue, qos = None, _QOS
        if kept:
            qos = replace(_QOS, depth=_MAX_KEPT if topic.endswith("tf_static") else min(kept, _MAX_KEPT))
            queue = FeedQueue(qos.depth, key_of(message_type), self._kept, lambda: None)
        history = _History(lambda: self._late_messages(topic, message_type)) if queue is None else queue
        publisher = self._node.create_publisher(message_type, topic, qos, history=history)
        opened = _Publication(publisher, message_type, queue, present.ids if present else set())
        if present is not None:
            present.publisher.close()
        self._topics[topic] = opened
        return opened

    def _store(self, topic: str, message: PublishOperation | str, size: int) -> None:
        now, recent = self._now(), self._recent
        recent.append(_KeptMessage(now, size, topic, message))
        self._recent_size += size
        while len(recent) > 1 and (recent[0].at <= now - _RECENT or self._recent_size > _MAX_CHARACTERS):
            self._recent_size -= recent.popleft().size

    def _late_messages(self, topic: str, message_type: type[Message]) -> Iterator[Message]:
        oldest = self._now() - _RECENT
        for sent in [recent.message for recent in self._recent if recent.topic == topic and recent.at > oldest][
            -_MAX_RECENT:
        ]:
            identifier: Identifier = None
            try:
                op = _operation_in(sent) if isinstance(sent, str) else sent
                identifier = op.id
                yield self._message(message_type, op)[0]
            except (FrameError, MissingRightError, TypeMismatchError) as exc:
                self._on_unfit("publish", topic, str(exc), identifier)


class _History:
    """The history of a publisher: stored frames, parsed for each late subscription."""

    def __init__(self, read: Callable[[], Iterator[Message]]) -> None:
        self._read = read

    def append(self, _item: object) -> None:
        """Do nothing: the message is stored already."""

    def __iter__(self) -> Iterator[Message]:
        return self._read()


def _operation_in(frame: str) -> PublishOperation:
    steps = parse_frame(frame)
    try:
        while True:
            next(steps)
    except StopIteration as end:
        op: PublishOperation = end.value
        return op
