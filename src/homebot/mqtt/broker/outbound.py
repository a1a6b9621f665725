"""The writer of packets to one client, in its protocol version, size limit and topic aliases. No I/O.

A message of QoS 1 or 2 is *in flight* from when it is written until the client has acknowledged it; their number is
bounded by the client's Receive Maximum. When the client resumes its session, all of them are sent again in the original
order.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Final, final

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
    Pubrel,
    ReasonCode,
    encode,
)
from homebot.mqtt.packets.properties import encode_properties
from homebot.mqtt.packets.publish import encode_publish_parts

__all__ = ["InFlight", "Outbound", "goodbye", "unread_connect_answer"]

_LONGEST_ALIASED = 512  # characters; each client remembers its topics


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
            head, tail = self._aliased(queued, alias)
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
        if len(topic) > _LONGEST_ALIASED:
            return 0
        known = self._aliases.get(topic)
        if known:
            return known
        used = len(self._aliases)
        return used + 1 if used < self._alias_maximum else 0

    def _aliased(self, queued: QueuedMessage, alias: int) -> tuple[bytes, bytes]:
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


_SMALL: Final = 1024  # bytes; smaller messages are not counted, because there are few


@final
class InFlight:
    """The messages that one client has not acknowledged.

    Attributes:
        messages: By packet id; None after PUBREC. Read-only, like the other attributes.
        size: The bytes of the large messages.
    """

    __slots__ = ("_count_bytes", "_last_id", "messages", "resend", "settled", "size", "window")

    def __init__(self, window: int, count: Callable[[int], None]) -> None:
        self.messages: dict[int, QueuedMessage | None] = {}
        self.resend: deque[int] = deque()
        self.window = window
        self.size = 0
        self.settled = 0
        self._count_bytes = count
        self._last_id = 0

    @property
    def full(self) -> bool:
        """True if nothing more can be sent until the client acknowledges something."""
        return len(self.messages) >= self.window

    def send(self, outbound: Outbound, queued: QueuedMessage) -> None:
        """Send a message with a new packet id; there must be room for it."""
        packet_id = self._last_id
        while True:
            packet_id = packet_id % 65_535 + 1
            if packet_id not in self.messages:
                break
        self._last_id = packet_id
        if outbound.publish(queued, packet_id):
            self.messages[packet_id] = queued
            if queued[0].size > _SMALL:
                self._count(queued, 1)

    def send_again(self, outbound: Outbound) -> None:
        """Send the next message that has to be repeated."""
        packet_id = self.resend.popleft()
        queued = self.messages[packet_id]
        if queued is not None and not outbound.publish(queued, packet_id, dup=True):
            del self.messages[packet_id]
            self._count(queued, -1)

    def resume(self, outbound: Outbound, window: int) -> None:
        """Repeat PUBREL to the connected client, and mark the other messages for repetition."""
        self.window = window
        self.resend.clear()
        for packet_id, queued in self.messages.items():
            if queued is None:
                outbound.send(Pubrel(packet_id))
            else:
                self.resend.append(packet_id)

    def acknowledged(self, packet_id: int) -> None:
        """Handle a PUBACK.

        Raises:
            PacketError: 0x82, the message was not sent at QoS 1.
        """
        if packet_id not in self.messages:
            return
        queued = self.messages[packet_id]
        if queued is None or queued[1] != 1:
            raise PacketError("PUBACK for a message at QoS 2", code=ReasonCode.PROTOCOL_ERROR)
        del self.messages[packet_id]
        self.settled += 1
        if queued[0].size > _SMALL:
            self._count(queued, -1)
        if self.resend:
            self._cancel_resend(packet_id)

    def received(self, packet_id: int, reason: ReasonCode) -> ReasonCode:
        """Handle a PUBREC; return the reason for PUBREL: 0, or 0x92 for an unknown id.

        Raises:
            PacketError: 0x82, the message was not sent at QoS 2.
        """
        if packet_id not in self.messages:
            return ReasonCode.PACKET_IDENTIFIER_NOT_FOUND
        queued = self.messages[packet_id]
        if queued is not None and queued.qos != 2:
            raise PacketError("PUBREC for a message at QoS 1", code=ReasonCode.PROTOCOL_ERROR)
        if reason.failed:
            self.completed(packet_id)
        else:
            self.messages[packet_id] = None
            if queued is not None:
                self._count(queued, -1)
            self._cancel_resend(packet_id)
        return ReasonCode.SUCCESS

    def completed(self, packet_id: int) -> None:
        """Handle a PUBCOMP, or a PUBREC that ends the exchange."""
        if packet_id in self.messages:
            self.settled += 1
            queued = self.messages.pop(packet_id)
            if queued is not None:
                self._count(queued, -1)
            self._cancel_resend(packet_id)

    def clear(self) -> list[QueuedMessage]:
        """Remove and return all messages that the client has not received."""
        messages = [each for each in self.messages.values() if each is not None]
        for queued in messages:
            self._count(queued, -1)
        self.messages.clear()
        self.resend.clear()
        return messages

    def _count(self, queued: QueuedMessage, sign: int) -> None:
        message = queued.message
        if message.size > _SMALL:
            self.size += sign * message.size
            (message.hold if sign > 0 else message.release)(self._count_bytes)

    def _cancel_resend(self, packet_id: int) -> None:
        if packet_id in self.resend:  # it was answered before its repetition
            self.resend.remove(packet_id)
