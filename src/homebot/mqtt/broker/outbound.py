"""The writer of packets to one client, in its protocol version, size limit and topic aliases. No I/O."""

from collections.abc import Callable
from dataclasses import replace
from typing import final

from homebot.clock import Clock
from homebot.mqtt.broker.ports import Transport
from homebot.mqtt.broker.queue import QueuedMessage
from homebot.mqtt.broker.stats import Counters
from homebot.mqtt.packets import (
    MAX_PACKET_SIZE,
    Connack,
    Disconnect,
    Packet,
    PacketError,
    PacketType,
    Properties,
    ProtocolVersion,
    ReasonCode,
    encode,
)
from homebot.mqtt.packets.properties import encode_properties
from homebot.mqtt.packets.publish import encode_publish_parts

_MAX_ALIASED = 512  # characters; each client remembers its topics


@final
class Outbound:
    """The writing half of one connection.

    Args:
        on_too_large: Called with the topic and size of a message that exceeds the client's limit, and the limit.
        max_packet_size: The largest packet that the client accepts, in bytes.
        alias_maximum: How many topic aliases the client accepts; 0 is none.
    """

    __slots__ = (
        "_alias_maximum",
        "_aliases",
        "_clock",
        "_counters",
        "_is_v5",
        "_on_too_large",
        "link",
        "max_packet_size",
        "version",
    )

    def __init__(
        self,
        link: Transport,
        clock: Clock,
        counters: Counters,
        version: ProtocolVersion,
        on_too_large: Callable[[str, int, int], None],
        max_packet_size: int = MAX_PACKET_SIZE,
        alias_maximum: int = 0,
    ) -> None:
        self.link = link
        self.version = version
        self.max_packet_size = max_packet_size
        self._is_v5 = version is ProtocolVersion.V5
        self._clock = clock
        self._counters = counters
        self._alias_maximum = alias_maximum
        self._on_too_large = on_too_large
        self._aliases: dict[str, int] = {}

    def send(self, packet: Packet) -> None:
        """Write *packet*."""
        self.link.write(encode(packet, self.version))

    def publish(self, queued: QueuedMessage, packet_id: int = 0, *, dup: bool = False) -> bool:
        """Write a message; return False, count and log, if it exceeds the client's packet size.

        Args:
            packet_id: 1 to 65,535 at QoS 1 and 2.
        """
        message, qos, retain, identifiers, _ = queued
        alias = self._alias_for(message.topic) if self._alias_maximum else 0
        if alias:
            head, tail = self._use_alias(queued, alias)
        elif identifiers or message.expires_at is not None:
            head, tail = message.parts(self.version, qos, retain, identifiers, self._clock.monotonic())
        elif message.kind == self._is_v5 << 3 | qos << 1 | retain:  # as parts(), which costs a call for each receiver
            head, tail = message.encoded
        else:
            head, tail = message.parts(self.version, qos, retain)
        data = b"".join((head, packet_id.to_bytes(2, "big"), tail)) if qos else head
        if len(data) > self.max_packet_size:
            self._counters.dropped_too_large += 1
            self._on_too_large(message.topic, len(data), self.max_packet_size)
            return False
        if alias:
            self._aliases[message.topic] = alias
        if dup:
            data = (data[0] | 8).to_bytes(1, "big") + data[1:]
        self._counters.messages_sent += 1
        self.link.write(data)
        return True

    def _alias_for(self, topic: str) -> int:
        """Return the alias of *topic*, old or new; 0 for none."""
        if len(topic) > _MAX_ALIASED:
            return 0
        known = self._aliases.get(topic)
        if known:
            return known
        used = len(self._aliases)
        return used + 1 if used < self._alias_maximum else 0

    def _use_alias(self, queued: QueuedMessage, alias: int) -> tuple[bytes, bytes]:
        message = queued.message
        known = message.topic in self._aliases
        properties = message.properties_for(queued.identifiers, self._clock.monotonic())
        head, tail = encode_publish_parts(
            "" if known else message.topic,
            message.payload,
            queued.qos,
            queued.retain,
            encode_properties(replace(properties, topic_alias=alias), PacketType.PUBLISH),
        )
        return (head, tail) if queued.qos else (head + tail, b"")


_MAX_REASON = 200  # enough to understand, without a topic of 64 KiB


def goodbye(reason: ReasonCode, reason_string: str, max_packet_size: int) -> bytes:
    """Return the DISCONNECT for an MQTT 5 client.

    Args:
        reason_string: The same for people, cut to 200 characters; left out where it is empty or does not fit.
    """
    plain = encode(Disconnect(reason))
    if not reason_string:
        return plain
    full = encode(Disconnect(reason, Properties(reason_string=reason_string[:_MAX_REASON])))
    return full if len(full) <= max_packet_size else plain


def unread_connect_answer(error: PacketError) -> bytes:
    """Return the CONNACK for an unreadable CONNECT, in its apparent version; empty if unknown."""
    if error.code is ReasonCode.UNSUPPORTED_PROTOCOL_VERSION:
        newer = error.frame[:6] == b"\0\4MQTT" and error.frame[6:7] > b"\5"
        return encode(Connack(reason=error.code), ProtocolVersion.V5 if newer else ProtocolVersion.V311)
    if b"\0\4MQTT\5" in error.frame[:16]:
        return encode(Connack(reason=error.code), ProtocolVersion.V5)
    return b""
