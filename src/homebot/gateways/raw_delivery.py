"""Delivery of raw messages by address to those that want them, and the last of each part for those that come later."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import anyio

from homebot.clock import Clock
from homebot.devices import GatewayNames, RawMessage
from homebot.errors import ClosedError, RefusedError
from homebot.graph import EntityKind, Node, Publisher, QoSProfile
from homebot.log import LogLimit
from homebot.messages import Time

SLOW_LISTENER = "gateway.slow_listener"

FULL_INBOX_WAIT = 0.2
"""Seconds for which a full inbox holds up the gateway before it loses its oldest.

Short, because meanwhile the broker queues for all: a default Mosquitto drops messages beyond 1,000.
"""

SLOW_READER_PENALTY = 60.0
"""Seconds for which a listener is not waited for again after it let that time pass."""

MAX_ADDRESSES = 100_000

_ROUNDED = 1e-6
_KEPT = 10
_KEPT_PAYLOAD = 4096
_MOMENT = 5.0
"""Seconds in which a new listener still gets an event: the first event announces its device, and is heard late."""

_RAW_QOS = QoSProfile(depth=10_000)


class RawDelivery:
    """Delivers raw messages, each address to its listeners.

    In *inbox* mode a node gets the messages of everything it asked for on one topic of its own, ``<node>/inbox``. In
    *mirror* mode, and for askers that are no node, each device has its topic ``received_data/<device>``.

    Attributes:
        by_address: The listeners of each address, none of an address without.
    """

    def __init__(self, node: Node, names: GatewayNames, *, inboxes: bool) -> None:
        self._node = node
        self._names = names
        self._inboxes = inboxes
        self._limit = LogLimit(node.graph.clock)
        self.by_address: defaultdict[str, list[Publisher[RawMessage]]] = defaultdict(list)
        self._by_topic: dict[str, Publisher[RawMessage]] = {}
        self._mirrored: dict[str, str] = {}
        self._askers: dict[str, _Asker] = {}
        self._no_wait_until: dict[str, float] = {}
        self._delivered: dict[str, int] = {}  # the hash of the last payload, by address

    def has(self, address: str, listener: str) -> bool:
        """Return whether the node *listener*, as it is now on the graph, asked for *address* before."""
        asker = self._askers.get(listener)
        return asker is not None and asker.node is self._node.graph.get_node(listener) and address in asker.addresses

    def add(self, address: str, key: str, name: str, listener: str) -> Publisher[RawMessage]:
        """Deliver the messages on *address*, of the device *key* called *name*, to *listener*; return the publisher.

        Args:
            listener: Full name of the node that asks; empty for a mirror topic.

        Raises:
            RefusedError: No such node is on the graph, or too many addresses are listened to.
            InvalidNameError: The device's name makes too long a topic name.
        """
        if address not in self.by_address and len(self.by_address) >= MAX_ADDRESSES:
            raise RefusedError(f"listening to {address}", f"{MAX_ADDRESSES:,} addresses are in use, the limit")
        asker = self._asker(listener)
        if self._inboxes and listener:
            if asker is None:
                raise RefusedError(f"an inbox for {listener}", "no such node is on the graph")
            topic = f"{listener}/inbox"
        else:
            short = self._names.received_data(name)
            if self._mirrored.setdefault(short, key) == key:
                topic = short
            else:
                topic = self._names.received_data(*key.split("/"))
        publisher = self._by_topic.get(topic)
        if publisher is None:
            publisher = self._by_topic[topic] = self._node.create_publisher(RawMessage, topic, _RAW_QOS)
        if publisher not in self.by_address[address]:
            self.by_address[address].append(publisher)
            self._delivered.pop(address, None)
        if asker is not None:
            asker.addresses.add(address)
        return publisher

    async def deliver(self, message: RawMessage, *, wait_if_full: bool) -> None:
        """Hand *message* to the listeners of its address.

        A retained one that repeats the last is left out: a broker sends it on each new link, although no device spoke.

        With *wait_if_full* it waits a moment for a full inbox rather than losing its oldest. A listener that let that
        pass is not waited for again for a minute: one that hangs must not hold up the others for long.
        """
        publishers, content = self.by_address.get(message.address), hash(message.payload)
        if not publishers or (message.retained and self._delivered.get(message.address) == content):
            return
        self._delivered[message.address] = content
        now, ends = self._node.graph.clock.monotonic, self._no_wait_until
        for publisher in tuple(publishers):
            try:
                if wait_if_full and publisher.is_full and now() >= ends.get(publisher.topic_name, 0.0):
                    with anyio.move_on_after(FULL_INBOX_WAIT):
                        await publisher.send(message)
                        continue
                    self._no_wait_until[publisher.topic_name] = self._node.graph.clock.monotonic() + SLOW_READER_PENALTY
                    if self._limit.allows(publisher.topic_name) is not None:
                        self._node.log.warning(
                            SLOW_LISTENER,
                            message=f"{publisher.topic_name} is full and not being read: "
                            "its oldest messages are dropped",
                            topic=publisher.topic_name,
                        )
                publisher.publish(message)
            except ClosedError:
                continue  # the listener left while this waited for another

    def drop_nodes_that_left(self) -> None:
        """Forget the nodes that left the graph, and the addresses without listeners."""
        for name, asker in tuple(self._askers.items()):
            if self._node.graph.get_node(name) is not asker.node:
                self._drop(name)

    async def watch_nodes(self) -> None:
        """Drop each node that leaves the graph, until cancelled."""
        with self._node.graph.watch() as changes:
            lost = 0
            async for change in changes:
                is_removal = change.change == "removed" and change.entity.kind is EntityKind.NODE
                if is_removal or changes.lost > lost:
                    lost = changes.lost
                    while changes.take() is not None:
                        pass
                    self.drop_nodes_that_left()

    def _asker(self, listener: str) -> _Asker | None:
        node = self._node.graph.get_node(listener)
        asker = self._askers.get(listener)
        if asker is not None and asker.node is node:
            return asker
        self._drop(listener)
        if node is None:
            return None
        asker = self._askers[listener] = _Asker(node)
        return asker

    def _drop(self, listener: str) -> None:
        asker = self._askers.pop(listener, None)
        publisher = self._by_topic.pop(f"{listener}/inbox", None)
        self._no_wait_until.pop(f"{listener}/inbox", None)
        if asker is None or publisher is None:
            return
        publisher.close()
        for address in asker.addresses:
            self.by_address[address].remove(publisher)
            if not self.by_address[address]:
                del self.by_address[address]
                self._delivered.pop(address, None)


@dataclass(slots=True)
class _Asker:
    node: Node
    addresses: set[str] = field(default_factory=set)


def begin_of(since: Time, clock: Clock) -> float:
    """Return the reading of the monotonic clock at the time *since*, a microsecond early at most.

    A clock that was set between the two would else hide new messages, or repeat old ones.
    """
    return clock.monotonic() - (clock.now() - since.to_seconds()) - _ROUNDED


class LateText(Protocol):
    """A maker of a text of at most 4 KiB; most are never asked for."""

    def __call__(self) -> RawMessage:
        """Return the text as a message."""
        ...


@dataclass(slots=True, eq=False)
class PartTexts:
    """The last texts of one part of a device.

    Attributes:
        events: Texts of events, as :attr:`kept`; they are good for a moment only.
    """

    _kept: tuple[tuple[float, RawMessage | LateText], ...] = field(default=(), init=False)
    events: tuple[tuple[float, RawMessage], ...] = field(default=(), init=False)

    @property
    def kept(self) -> tuple[tuple[float, RawMessage], ...]:
        """Its last 10 states as text, of at most 4 KiB, and when each came, for a listener that comes later."""
        made = tuple((came, message if isinstance(message, RawMessage) else message()) for came, message in self._kept)
        self._kept = made
        return made

    def copy_texts(self, before: PartTexts) -> None:
        """Take over the texts of the same part as it was described *before*."""
        self._kept, self.events = before._kept, before.events

    def record(self, message: RawMessage, now: float, *, is_event: bool) -> None:
        """Remember a text that came at *now* on the monotonic clock, unless it is long."""
        if len(message.payload) > _KEPT_PAYLOAD:
            return
        if is_event:
            self.events = (*self.events[1 - _KEPT :], (now, message))
        else:
            self._kept = (*self._kept[1 - _KEPT :], (now, message))

    def record_lazy(self, make: LateText, now: float) -> None:
        """Remember a state that came at *now*, with its text made on demand."""
        self._kept = (*self._kept[1 - _KEPT :], (now, make))

    def missed_by(self, since: float, now: float) -> tuple[RawMessage, ...]:
        """Return the kept texts that a listener wants that was there from *since* on, on the monotonic clock.

        A retained message is among them if it is still the part's last text.
        """
        recent, kept = missed(self.events, max(since, now - _MOMENT)), self.kept
        if not recent:
            return missed(kept, since)
        wanted = {id(message) for message in (*recent, *missed(kept, since))}
        in_order = sorted((*kept, *self.events), key=lambda dated: dated[0])
        return tuple(message for _, message in in_order if id(message) in wanted)


def missed(kept: Sequence[tuple[float, RawMessage]], since: float) -> tuple[RawMessage, ...]:
    """Return those of the *kept* messages that came from *since* on, and the last where it was retained."""
    last = kept[-1][1] if kept else None
    return tuple(message for came, message in kept if came >= since or (message is last and message.retained))
