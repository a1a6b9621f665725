"""The data types that packets are made of: integers, text, binary data. Source: MQTT 5.0, section 1.5."""

from typing import final

from homebot.errors import UsageError
from homebot.mqtt.packets.reason import PacketError

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
