"""The data types that packets are made of, reason codes, protocol versions, and the error that every bad packet raises.

Source: MQTT 5.0, sections 1.5 and 2.4.
"""

from enum import IntEnum, unique
from typing import Final, final

from homebot.errors import UsageError, WireError

__all__ = [
    "FAILURES",
    "MAX_UINT16",
    "MAX_VARINT",
    "Cursor",
    "PacketError",
    "ProtocolVersion",
    "ReasonCode",
    "by_number",
    "encode_binary",
    "encode_text",
    "encode_uint16",
    "encode_varint",
]


@unique
class ProtocolVersion(IntEnum):
    """The protocol level a client asks for in CONNECT."""

    V31 = 3
    V311 = 4
    V5 = 5


@unique
class ReasonCode(IntEnum):
    """The result of a request. Below 0x80 it worked. Source: MQTT 5.0, section 2.4.

    In SUBACK 0x00 to 0x02 are the granted QoS. MQTT 3 has other numbers in CONNACK; the codec translates, so
    the rest of the program knows only these.
    """

    SUCCESS = 0x00
    GRANTED_QOS_1 = 0x01
    GRANTED_QOS_2 = 0x02
    DISCONNECT_WITH_WILL = 0x04
    NO_MATCHING_SUBSCRIBERS = 0x10
    NO_SUBSCRIPTION_EXISTED = 0x11
    CONTINUE_AUTHENTICATION = 0x18
    REAUTHENTICATE = 0x19
    UNSPECIFIED_ERROR = 0x80
    MALFORMED_PACKET = 0x81
    PROTOCOL_ERROR = 0x82
    IMPLEMENTATION_SPECIFIC_ERROR = 0x83
    UNSUPPORTED_PROTOCOL_VERSION = 0x84
    CLIENT_IDENTIFIER_NOT_VALID = 0x85
    BAD_USER_NAME_OR_PASSWORD = 0x86
    NOT_AUTHORIZED = 0x87
    SERVER_UNAVAILABLE = 0x88
    SERVER_BUSY = 0x89
    BANNED = 0x8A
    SERVER_SHUTTING_DOWN = 0x8B
    BAD_AUTHENTICATION_METHOD = 0x8C
    KEEP_ALIVE_TIMEOUT = 0x8D
    SESSION_TAKEN_OVER = 0x8E
    TOPIC_FILTER_INVALID = 0x8F
    TOPIC_NAME_INVALID = 0x90
    PACKET_IDENTIFIER_IN_USE = 0x91
    PACKET_IDENTIFIER_NOT_FOUND = 0x92
    RECEIVE_MAXIMUM_EXCEEDED = 0x93
    TOPIC_ALIAS_INVALID = 0x94
    PACKET_TOO_LARGE = 0x95
    MESSAGE_RATE_TOO_HIGH = 0x96
    QUOTA_EXCEEDED = 0x97
    ADMINISTRATIVE_ACTION = 0x98
    PAYLOAD_FORMAT_INVALID = 0x99
    RETAIN_NOT_SUPPORTED = 0x9A
    QOS_NOT_SUPPORTED = 0x9B
    USE_ANOTHER_SERVER = 0x9C
    SERVER_MOVED = 0x9D
    SHARED_SUBSCRIPTIONS_NOT_SUPPORTED = 0x9E
    CONNECTION_RATE_EXCEEDED = 0x9F
    MAXIMUM_CONNECT_TIME = 0xA0
    SUBSCRIPTION_IDENTIFIERS_NOT_SUPPORTED = 0xA1
    WILDCARD_SUBSCRIPTIONS_NOT_SUPPORTED = 0xA2

    @property
    def failed(self) -> bool:
        """True if the code is a refusal or an error."""
        return self >= 0x80

    @property
    def text(self) -> str:
        """The code for people, such as ``not authorized``."""
        return self.name.lower().replace("_", " ")


FAILURES: Final = tuple(code for code in ReasonCode if code.failed)
"""All codes of refusals and errors."""


def by_number(*codes: ReasonCode) -> dict[int, ReasonCode]:
    """Return *codes* by their numbers."""
    return {int(code): code for code in codes}


class PacketError(WireError):
    """A peer sent a packet that cannot be parsed or that MQTT does not allow."""

    def __init__(self, problem: str, frame: bytes = b"", code: ReasonCode = ReasonCode.MALFORMED_PACKET) -> None:
        super().__init__(problem, frame)
        self.code = code


MAX_VARINT = 268_435_455
"""The largest number that four bytes of variable-length coding hold."""

MAX_UINT16 = 65_535
"""The largest number that two bytes hold, and so the most bytes of a text."""


@final
class Cursor:
    """Reads the body of one packet from front to back.

    Every method advances by the bytes read and raises :class:`PacketError` (0x81) where the body ends too early
    or does not hold the type.

    Args:
        body: All bytes behind the fixed header.
    """

    __slots__ = ("body", "end", "position")

    def __init__(self, body: bytes) -> None:
        self.body = body
        self.position = 0
        self.end = len(body)

    @property
    def left(self) -> int:
        """Number of bytes not read yet."""
        return self.end - self.position

    def read(self, size: int) -> bytes:
        """Read the next *size* bytes."""
        start = self.position
        stop = start + size
        if stop > self.end:
            raise PacketError(f"the packet ends {stop - self.end} bytes too early", self.body)
        self.position = stop
        return self.body[start:stop]

    def uint8(self) -> int:
        """Read one byte."""
        return self.read(1)[0]

    def uint16(self) -> int:
        """Read two bytes, big-endian."""
        return int.from_bytes(self.read(2), "big")

    def uint32(self) -> int:
        """Read four bytes, big-endian."""
        return int.from_bytes(self.read(4), "big")

    def varint(self) -> int:
        """Read a variable byte integer, 0 to 268,435,455, in its shortest form."""
        value = shift = 0
        while True:
            byte = self.uint8()
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                if byte == 0 and shift:
                    raise PacketError("a variable byte integer is longer than needed", self.body)
                return value
            shift += 7
            if shift > 21:
                raise PacketError("a variable byte integer is longer than four bytes", self.body)

    def binary(self) -> bytes:
        """Read two bytes of length and the data."""
        return self.read(self.uint16())

    def text(self) -> str:
        """Read two bytes of length and UTF-8, without U+0000 and surrogates."""
        raw = self.binary()
        try:
            text = raw.decode()
        except UnicodeDecodeError:
            raise PacketError("text is not valid UTF-8", self.body) from None
        if "\0" in text:
            raise PacketError("text has a NUL", self.body)
        return text

    def finish(self) -> None:
        """Make sure that nothing is left."""
        if self.position != self.end:
            raise PacketError(f"the packet has {self.left} extra bytes", self.body)


def encode_varint(value: int) -> bytes:
    """Encode a variable byte integer in its shortest form.

    Raises:
        UsageError: The value is not in 0 to 268,435,455.
    """
    if 0 <= value < 0x80:
        return value.to_bytes(1, "big")
    if not 0 <= value <= MAX_VARINT:
        raise UsageError(f"{value} does not fit into a variable byte integer (0 to {MAX_VARINT})")
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def encode_uint16(value: int) -> bytes:
    """Encode two bytes, big-endian.

    Raises:
        UsageError: The value is not in 0 to 65,535.
    """
    if not 0 <= value <= MAX_UINT16:
        raise UsageError(f"{value} does not fit into two bytes")
    return value.to_bytes(2, "big")


def encode_binary(data: bytes) -> bytes:
    """Encode two bytes of length and the data.

    Raises:
        UsageError: The data is longer than 65,535 bytes.
    """
    if len(data) > MAX_UINT16:
        raise UsageError(f"{len(data)} bytes do not fit into an MQTT field ({MAX_UINT16} is the limit)")
    return len(data).to_bytes(2, "big") + data


def encode_text(text: str) -> bytes:
    """Encode two bytes of length and UTF-8.

    Raises:
        UsageError: The text is longer than 65,535 bytes, or holds U+0000 or a surrogate.
    """
    if "\0" in text:
        raise UsageError(f"text has a NUL: {text[:40]!r}")
    try:
        raw = text.encode()
    except UnicodeEncodeError:
        raise UsageError(f"text cannot be encoded as UTF-8: {text[:40]!r}") from None
    return len(raw).to_bytes(2, "big") + raw if len(raw) <= MAX_UINT16 else encode_binary(raw)  # which says why
