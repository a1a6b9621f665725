"""The codec: any packet to bytes and back, and a stream of bytes into packets."""

from collections.abc import Callable, Iterator
from typing import TypeAlias, final

from homebot.mqtt.packets import connect, publish, subscribe
from homebot.mqtt.packets.connect import Auth, Connack, Connect, Disconnect, Pingreq, Pingresp
from homebot.mqtt.packets.primitives import MAX_VARINT
from homebot.mqtt.packets.properties import PacketType
from homebot.mqtt.packets.publish import Acknowledgement, Puback, Publish, decode_publish
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion, ReasonCode
from homebot.mqtt.packets.subscribe import Suback, Subscribe, Unsuback, Unsubscribe

Packet: TypeAlias = (
    Connect
    | Connack
    | Publish
    | Acknowledgement
    | Subscribe
    | Suback
    | Unsubscribe
    | Unsuback
    | Pingreq
    | Pingresp
    | Disconnect
    | Auth
)


def decode(first: int, body: bytes, version: ProtocolVersion) -> Packet:
    """Decode one packet.

    Args:
        first: The first byte: type and flags.
        version: Protocol version of the connection; a CONNECT brings its own.

    Raises:
        PacketError: 0x81 the packet is malformed, 0x82 it has something forbidden, 0x84 it asks for another protocol,
            0x8F a filter breaks the rules for filters, 0x90 a topic is no topic name, 0x94 a topic alias is 0, 0x97
            there is too much of something.
    """
    number = first >> 4
    if number == PacketType.PUBLISH:
        return decode_publish(first & 0x0F, body, 0, len(body), version)
    if number == 0 or not _may_have(first & 0x0F, number, version):
        raise PacketError(f"0x{first:02x} does not start a packet", body)
    return _DECODERS[PacketType(number)](body, version)


def encode(packet: Packet, version: ProtocolVersion = ProtocolVersion.V5) -> bytes:
    """Encode one packet; a CONNECT ignores *version* and takes its own.

    Raises:
        UsageError: A value does not fit its field, or this version has no such packet or property.
    """
    return _ENCODERS[type(packet)](packet, version)


def _may_have(flags: int, number: int, version: ProtocolVersion) -> bool:
    """Return whether a packet may have *flags*; 3.1, section 2.1, has DUP in more packets, later ones fix all bits."""
    if version == ProtocolVersion.V31:
        return number not in _FLAGS_2 or flags & 0b0110 == 0b0010
    return flags == (0b0010 if number in _FLAGS_2 else 0)


_FLAGS_2 = (PacketType.PUBREL, PacketType.SUBSCRIBE, PacketType.UNSUBSCRIBE)
_DECODERS: dict[PacketType, Callable[[bytes, ProtocolVersion], Packet]] = {
    **connect.DECODERS,
    **publish.DECODERS,
    **subscribe.DECODERS,
}
_ENCODERS: dict[type, Callable[..., bytes]] = connect.ENCODERS | publish.ENCODERS | subscribe.ENCODERS


MAX_PACKET_SIZE = MAX_VARINT + 5
"""The largest packet MQTT can express, in bytes, fixed header included."""


_OF_ANY_SIZE = (PacketType.CONNECT << 4, PacketType.PUBLISH << 4)


@final
class PacketReader:
    """An incremental reader: give it bytes as they come, take packets as they are complete.

    If all packets are popped after each :meth:`feed`, it never holds more
    than one packet of *max_packet_size*. After a :class:`PacketError` the stream is lost: every later
    :meth:`pop` raises the same error.

    Attributes:
        missing: How many bytes of a packet that has begun are still to come, as far as that is known.

    Args:
        version: The protocol version. May be set later, but not while packets are waiting; a server
            sets it from CONNECT, which needs none.
        max_packet_size: A larger packet is refused (0x95) as soon as its length is known, in bytes.
        max_control_size: The same for all packets but CONNECT and PUBLISH, which are read in one piece.
    """

    __slots__ = ("_data", "_error", "_position", "_tail", "max_control_size", "max_packet_size", "missing", "version")

    def __init__(
        self,
        version: ProtocolVersion = ProtocolVersion.V5,
        max_packet_size: int = MAX_PACKET_SIZE,
        max_control_size: int = MAX_PACKET_SIZE,
    ) -> None:
        self.version = version
        self.max_control_size = max_control_size
        self.max_packet_size = max_packet_size
        self._data = b""
        self._position = 0
        self._tail = bytearray()  # behind _data; announced lengths are not reserved in advance
        self.missing = 0
        self._error: PacketError | None = None

    @property
    def held(self) -> int:
        """Bytes that were fed and not taken yet."""
        return len(self._data) - self._position + len(self._tail)

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Add *data* and iterate over the packets that are complete now.

        The bytes are taken at once. Packets not taken from the iterator stay for the next call or for
        :meth:`pop`.

        Raises:
            PacketError: While iterating, at the first packet that cannot be; the ones before it have come.
        """
        if self.missing > len(data):
            self.missing -= len(data)
            self._tail += data
            return iter(())
        self.missing = 0
        if self._tail:
            self._data = b"".join((self._data[self._position :], self._tail, data))
            self._tail = bytearray()
        elif self._position == len(self._data):
            self._data = data
        else:
            self._data = self._data[self._position :] + data
        self._position = 0
        return iter(self.pop, None)

    def pop(self) -> Packet | None:
        """Return the next complete packet, or None.

        Raises:
            PacketError: As :meth:`feed`.
        """
        data = self._data
        position = self._position
        left = len(data) - position
        if left < 2 or self.missing:
            self._forget_taken()
            return None
        size = data[position + 1]
        body = position + 2
        if size > 0x7F:
            if self._error is not None:
                raise self._error
            long_form = self._long_size(size & 0x7F, body)
            if long_form is None:
                self._forget_taken()
                return None
            size, body = long_form
        end = body + size
        if end - position > self.max_packet_size:
            raise self._fail(f"a packet of {end - position} bytes is too large", ReasonCode.PACKET_TOO_LARGE)
        if end > len(data):
            self.missing = end - len(data)
            self._forget_taken()
            return None
        first = data[position]
        try:
            if first & 0xF0 == 0x30:
                packet: Packet = decode_publish(first & 0x0F, data, body, end, self.version)
            elif first == 0x40 and size == 2 and (packet_id := data[body] << 8 | data[body + 1]):
                packet = Puback(packet_id)  # the plain form of the packet that comes as often as PUBLISH
            else:
                packet = decode(first, data[body:end], self.version)
        except PacketError as error:
            self._error = error
            raise
        self._position = end
        return packet

    def _forget_taken(self) -> None:
        """Keep no packet in memory for the sake of the few bytes behind it."""
        if self._position:
            self._data = self._data[self._position :]
            self._position = 0

    def _long_size(self, size: int, position: int) -> tuple[int, int] | None:
        data = self._data
        for shift in (7, 14, 21):
            if position == len(data):
                return None
            byte = data[position]
            position += 1
            size |= (byte & 0x7F) << shift
            if byte < 0x80:
                if byte == 0:
                    raise self._fail("the remaining length is longer than needed")
                if size > self.max_control_size and data[self._position] & 0xF0 not in _OF_ANY_SIZE:
                    raise self._fail(f"a packet of {size} bytes is too large for its type", ReasonCode.PACKET_TOO_LARGE)
                return size, position
        raise self._fail("the remaining length is longer than four bytes")

    def _fail(self, problem: str, code: ReasonCode = ReasonCode.MALFORMED_PACKET) -> PacketError:
        self._error = PacketError(problem, self._data[self._position : self._position + 16], code)
        return self._error
