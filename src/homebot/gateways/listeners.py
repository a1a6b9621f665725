"""Who wants the raw messages of which address, and how they get them."""

from __future__ import annotations

from collections import defaultdict

import anyio

from homebot.devices import GatewayNames, RawMessage
from homebot.errors import RefusedError
from homebot.graph import Node, Publisher, QoSProfile
from homebot.log import LogLimit

__all__ = ["Listeners"]

SLOW_LISTENER = "gateway.slow_listener"

PATIENCE = 5.0
"""Seconds for which a full inbox holds up the gateway (and, through it, the broker) before it loses its oldest."""

MAX_ADDRESSES = 100_000

_RAW_QOS = QoSProfile(depth=1000)


class Listeners:
    """Delivers raw messages, each address to whoever asked for it.

    In *inbox* mode a node gets the messages of everything it asked for on one topic of its own, ``<node>/inbox``. In
    *mirror* mode, and for askers that are no node, each device has its topic ``received_data/<device>``.

    Args:
        node: The gateway's node.
        names: Its names.
        inboxes: Whether nodes get inboxes.
    """

    def __init__(self, node: Node, names: GatewayNames, *, inboxes: bool) -> None:
        self._node = node
        self._names = names
        self._inboxes = inboxes
        self._limit = LogLimit(node.graph.clock)
        self._by_address: defaultdict[str, list[Publisher[RawMessage]]] = defaultdict(list)
        self._by_topic: dict[str, Publisher[RawMessage]] = {}
        self._mirrored: dict[str, str] = {}

    def add(self, address: str, key: str, name: str, listener: str) -> Publisher[RawMessage]:
        """Deliver what is said on *address*, by the device *key* called *name*, to *listener*, from now on.

        Args:
            address: Where the device speaks.
            key: What the gateway calls the device.
            name: What people call it; names its mirror topic.
            listener: Full name of the node that asks; empty for a mirror topic.

        Returns:
            The publisher that delivers; its topic is where the messages come.

        Raises:
            RefusedError: No such node is on the graph, or too many addresses are listened to.
            InvalidNameError: The device's name makes too long a topic name.
        """
        if self._inboxes and listener:
            if self._node.graph.get_node(listener) is None:
                raise RefusedError(f"an inbox for {listener}", "no such node is on the graph")
            topic = f"{listener}/inbox"
        else:
            topic = self._mirror_topic(key, name)
        if address not in self._by_address and len(self._by_address) >= MAX_ADDRESSES:
            raise RefusedError(f"listening to {address}", f"{MAX_ADDRESSES} addresses are listened to already")
        publisher = self._by_topic.get(topic)
        if publisher is None:
            publisher = self._by_topic[topic] = self._node.create_publisher(RawMessage, topic, _RAW_QOS)
        if publisher not in self._by_address[address]:
            self._by_address[address].append(publisher)
        return publisher

    def of(self, address: str) -> list[Publisher[RawMessage]]:
        """Return who gets what is said on *address*; the same list for ever, so that it can be kept."""
        return self._by_address[address]

    async def deliver(self, publisher: Publisher[RawMessage], message: RawMessage, *, patient: bool) -> None:
        """Hand *message* over; a *patient* delivery waits up to 5 s for a full inbox rather than losing its oldest."""
        if patient and publisher.is_full:
            with anyio.move_on_after(PATIENCE) as waiting:
                await publisher.send(message)
                return
            if waiting.cancelled_caught and self._limit.allows(publisher.topic_name) is not None:
                self._node.log.warning(
                    SLOW_LISTENER,
                    message=f"{publisher.topic_name} is full and not read: its oldest messages are lost",
                    topic=publisher.topic_name,
                )
        publisher.publish(message)

    def drop_node(self, listener: str) -> None:
        """Forget the inbox of a node that left the graph."""
        publisher = self._by_topic.pop(f"{listener}/inbox", None)
        if publisher is not None:
            for publishers in self._by_address.values():
                if publisher in publishers:
                    publishers.remove(publisher)
            publisher.close()

    def _mirror_topic(self, key: str, name: str) -> str:
        """The device's name alone, unless a device of another key has it already."""
        short = self._names.received_data(name)
        if self._mirrored.setdefault(short, key) == key:
            return short
        return self._names.received_data(*key.split("/"))
