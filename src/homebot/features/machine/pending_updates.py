"""The news of one gateway that the homebot that follows it has not taken yet."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, Final

from homebot.devices import GatewayNames, GatewayState, RawMessage, Sighting
from homebot.devices.gateway_messages import CommandAnswer, Report
from homebot.devices.health import Quarantine
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.support.bounded_map import BoundedMap

if TYPE_CHECKING:
    from homebot.graph import Node, Subscription
    from homebot.messages.message import Message

_QOS: Final = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MAX_OF_KIND: Final = {GatewayState: 1, CommandAnswer: 1000, RawMessage: 1000}
MAX_OF_EACH: Final = 500_000
"""Devices and reports: as many as a gateway may keep for late joiners."""


class PendingUpdates:
    """The newest of each device and report of a gateway, and its other news, since they were last taken.

    Args:
        on_news: Called when there is some.
    """

    def __init__(self, node: Node, gateway: str, on_news: Callable[[], object]) -> None:
        names = GatewayNames(gateway)
        self._node, self._from, self._on_news = node, names.node, on_news
        self._topics: dict[str, tuple[type[Message], str]] = {
            "states": (GatewayState, names.state),
            "sightings": (Sighting, names.received_topics),
            "quarantines": (Quarantine, names.quarantine),
            "reports": (Report, names.readings),
            "answers": (CommandAnswer, names.answers),
        }
        self._waiting: dict[str, BoundedMap[Hashable, Message]] = {
            field: BoundedMap(_most(kind)) for field, (kind, _) in self._topics.items()
        }
        self._waiting["raw"] = BoundedMap(_most(RawMessage))
        self._numbers = count()
        self._sources: list[Subscription[Any]] = []  # any message
        self._raw: dict[str, Subscription[RawMessage]] = {}

    def __bool__(self) -> bool:
        return any(self._waiting.values())

    def begin(self) -> dict[str, tuple[str, ...]]:
        """Wait for everything again that there is; return the keys of all devices and the streams of all reports."""
        self.close()
        for field, (kind, topic) in self._topics.items():
            source = self._node.create_subscription(kind, topic, qos_profile=_QOS, from_node=self._from)
            self._sources.append(source)
            add = partial(self._add, field)
            add(iter(source.take, None))
            self._node.create_task(partial(source.run_batches, add))
        sightings, reports = self._waiting["sightings"], self._waiting["reports"]
        return {"keys": tuple(map(str, sightings)), "streams": tuple(map(str, reports))}

    def listen(self, topic: str) -> None:
        """Follow the raw messages on *topic* too."""
        if topic not in self._raw:
            self._raw[topic] = self._node.create_subscription(
                RawMessage, topic, lambda message: self._add("raw", iter((message,))), 1000, from_node=self._from
            )

    def pop(self, most: int) -> dict[str, tuple[Message, ...]]:
        """Return at most *most* messages, by their fields in the answer; those of devices before their reports."""
        taken: dict[str, tuple[Message, ...]] = {}
        for field, waiting in self._waiting.items():
            share = min(most, len(waiting))
            taken[field] = tuple(waiting.popitem(last=False)[1] for _ in range(share))
            most -= share
        return taken

    def close(self) -> None:
        """Follow nothing more, and forget all waiting news."""
        for source in [*self._sources, *self._raw.values()]:
            source.close()
        self._sources.clear()
        self._raw.clear()
        for waiting in self._waiting.values():
            waiting.clear()

    def _add(self, field: str, messages: Iterator[Message]) -> None:
        waiting = self._waiting[field]
        for message in messages:
            key = next(self._numbers) if message.key_field is None else getattr(message, message.key_field)
            waiting[key] = message
        self._on_news()


def _most(kind: type[Message]) -> int:
    return _MAX_OF_KIND.get(kind, MAX_OF_EACH)
