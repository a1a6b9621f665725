"""Announcements that wait until there is work to spare for them. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from homebot.gateways.mqtt.work_budget import MESSAGE_WORK
from homebot.mqtt.message import MqttMessage

__all__ = ["DeferredMessages"]

MAX_BYTES = 16 * 1024 * 1024
"""Bytes of all that wait, each message counted with those that it costs beside its payload."""

MAX_WORK_EACH = 512 * 1024
"""Work that may wait on one topic: half a second of its budget."""

_OVERHEAD = 1024


@dataclass(slots=True)
class _Topic:
    payer: str
    messages: list[tuple[MqttMessage, bool]] = field(default_factory=list)
    work: int = 0


class DeferredMessages:
    """The messages that wait for a budget: the newest of each topic, in their order.

    Of too many on one topic those go first that do not look like what was accepted there, the oldest of them first. Of
    too many in all those go first on whose topics no device stands announced, the oldest of them first.

    Args:
        max_bytes: Bytes of all of them.

    Attributes:
        dropped: Messages that were dropped.
        bytes: Bytes of all that wait.
    """

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self.dropped = 0
        self.bytes = 0
        self._max_bytes = max_bytes
        self._topics: dict[str, _Topic] = {}
        self._own: dict[str, OrderedDict[str, _Topic]] = {}
        self._shared: dict[str, OrderedDict[str, _Topic]] = {}

    def __contains__(self, topic: str) -> bool:
        return topic in self._topics

    def __bool__(self) -> bool:
        return bool(self._topics)

    def waits_for(self, payer: str) -> bool:
        """Return whether a message waits for the budget of *payer*."""
        return payer in self._own or payer in self._shared

    def add(self, message: MqttMessage, payer: str, *, is_like: bool) -> None:
        """Let *message* wait for the budget of *payer*; *is_like* if it looks like what was accepted on its topic."""
        topic = self._topics.get(message.topic)
        if topic is None:
            topic = self._topics[message.topic] = _Topic(payer)
        groups = self._own if topic.payer == message.topic else self._shared
        group = groups.setdefault(topic.payer, OrderedDict())
        group[message.topic] = topic
        group.move_to_end(message.topic)
        topic.messages.append((message, is_like))
        topic.work += _work(message)
        self.bytes += _size(message)
        while topic.work > MAX_WORK_EACH and len(topic.messages) > 1:
            self._drop_one(topic)
        while self.bytes > self._max_bytes and len(self._topics) > 1:
            self._drop_oldest(group)

    def drop(self, topic: str) -> None:
        """Let nothing on *topic* wait any more."""
        while topic in self._topics:
            self._pop(topic, 0)

    def take(self, admits: Callable[[str], bool]) -> Iterator[MqttMessage]:
        """Take out what is no longer to wait, one message of each budget in turn until none *admits* one more.

        Those of a topic come in their order; of the topics that share a budget the newest comes first, so that somebody
        new is not behind a flood.
        """
        is_done = False
        while not is_done:
            is_done = True
            for groups in (self._own, self._shared):
                for payer in tuple(groups):
                    if payer in groups and admits(payer):
                        is_done = False
                        yield self._pop(next(reversed(groups[payer])), 0)

    def _pop(self, name: str, index: int) -> MqttMessage:
        topic = self._topics[name]
        message, _ = topic.messages.pop(index)
        topic.work -= _work(message)
        self.bytes -= _size(message)
        if not topic.messages:
            del self._topics[name]
            groups = self._own if topic.payer == name else self._shared
            del groups[topic.payer][name]
            if not groups[topic.payer]:
                del groups[topic.payer]
        return message

    def _drop_one(self, topic: _Topic) -> None:
        """Drop the oldest message that looks like nothing known, else the oldest."""
        unlike = next((index for index, (_, is_like) in enumerate(topic.messages) if not is_like), 0)
        self._pop(topic.messages[0][0].topic, unlike)
        self.dropped += 1

    def _drop_oldest(self, newest: OrderedDict[str, _Topic]) -> None:
        group = next(iter(self._shared.values()), None) or next(
            (one for one in self._own.values() if one is not newest), newest
        )
        self._pop(next(iter(group)), 0)
        self.dropped += 1


def _work(message: MqttMessage) -> int:
    return MESSAGE_WORK + len(message.payload)


def _size(message: MqttMessage) -> int:
    return _OVERHEAD + len(message.topic) + len(message.payload)
