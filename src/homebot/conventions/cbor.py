"""Documents in CBOR, in and out. Pure, and bounded for any input.

It reads the values of JSON: tags are ignored, and byte strings become text, with replacements for invalid UTF-8,
unless they are asked for. cbor2 (6.3) bounds no number of items: 256 KiB of them hold up the loop for 70 ms.

Source: RFC 8949, sections 3 and 4; the examples of its appendix A are tests.
"""

import math
import struct

from homebot.conventions.payload import MAX_STATE_BYTES
from homebot.errors import WireError

_MAX_DEPTH = 32
_MAX_ITEMS = 10_000
_INDEFINITE = 31
_FLOATS = {25: ">e", 26: ">f", 27: ">d"}
_BREAK = object()


def decode_cbor(payload: bytes, longest: int = MAX_STATE_BYTES, *, as_bytes: bool = False) -> object:
    """Return the document in *payload*: one data item and nothing after it.

    Args:
        longest: The limit of its length in bytes.
        as_bytes: Whether byte strings of a stated length stay bytes.

    Raises:
        WireError: It is no CBOR, or too long, too deep or too large.
    """
    if len(payload) > longest:
        raise WireError(f"CBOR of {len(payload)} bytes is longer than {longest}")
    reader = _Reader(payload, as_bytes=as_bytes)
    value = reader.item(_MAX_DEPTH)
    if value is _BREAK:
        raise WireError("CBOR has a break that ends nothing", payload)
    if reader.at != len(payload):
        raise WireError(f"CBOR has {len(payload) - reader.at} bytes after its end", payload)
    return value


def encode_cbor(document: object) -> bytes:
    """Return *document* in CBOR, as short as RFC 8949, section 4.1, prefers it, but for floats of 16 bit.

    Raises:
        TypeError: It has other values than null, booleans, numbers, texts, lists, and objects with texts or whole
            numbers as keys.
    """
    match document:
        case None:
            return b"\xf6"
        case bool():
            return b"\xf5" if document else b"\xf4"
        case int() if -(2**64) <= document < 2**64:
            return cbor_head(int(document < 0), max(document, -1 - document))
        case int() | float():
            return _encode_float(float(document))
        case str():
            encoded = document.encode(errors="replace")
            return cbor_head(3, len(encoded)) + encoded
        case list() | tuple():
            return cbor_head(4, len(document)) + b"".join(map(encode_cbor, document))
        case dict():
            pairs = (encode_cbor(key) + encode_cbor(value) for key, value in document.items())
            return cbor_head(5, len(document)) + b"".join(pairs)
    raise TypeError(f"CBOR of a {type(document).__name__} is not supported")


def _encode_float(number: float) -> bytes:
    try:
        short = struct.pack(">f", number)
    except OverflowError:
        short = b""
    is_exact = bool(short) and struct.unpack(">f", short)[0] == number
    return b"\xfa" + short if is_exact else b"\xfb" + struct.pack(">d", number)


def cbor_head(major: int, number: int) -> bytes:
    """Return the first bytes of an item: its *major* type and a *number*, such as its length (RFC 8949, section 3)."""
    for code, layout, limit in ((24, ">B", 2**8), (25, ">H", 2**16), (26, ">I", 2**32), (27, ">Q", 2**64)):
        if number < 24:
            return bytes([major << 5 | number])
        if number < limit:
            return bytes([major << 5 | code]) + struct.pack(layout, number)
    raise TypeError(f"{number} is too large for CBOR")


class _Reader:
    """Reader of the items of a payload, with the place of the next one."""

    def __init__(self, payload: bytes, *, as_bytes: bool) -> None:
        self.at = 0
        self._payload = payload
        self._as_bytes = as_bytes
        self._items = 0

    def item(self, depth: int) -> object:
        self._items += 1
        if self._items > _MAX_ITEMS:
            raise WireError(f"CBOR has more than {_MAX_ITEMS} items")
        if depth <= 0:
            raise WireError(f"CBOR is nested deeper than {_MAX_DEPTH} levels")
        first = self._consume(1)[0]
        major, info = first >> 5, first & 31
        if major == 7:
            return self._simple(info)
        if info == _INDEFINITE and major in {2, 3, 4, 5}:
            return self._indefinite(major, depth)
        return self._definite(major, self._number(info), depth)

    def _definite(self, major: int, number: int, depth: int) -> object:
        match major:
            case 0:
                return number
            case 1:
                return -1 - number
            case 2:
                content = self._consume(number)
                return content if self._as_bytes else content.decode(errors="replace")
            case 3:
                return _text(self._consume(number))
            case 4:
                return [self._inner(depth) for _ in range(self._count(number))]
            case 5:
                return dict([self._pair(depth) for _ in range(self._count(number))])
        return self._inner(depth)  # a tag

    def _consume(self, count: int) -> bytes:
        content = self._payload[self.at : self.at + count]
        if len(content) < count:
            raise WireError("CBOR ends too early", self._payload)
        self.at += count
        return content

    def _number(self, info: int) -> int:
        if info < 24:
            return info
        if info > 27:
            raise WireError(f"CBOR has the reserved information {info}", self._payload)
        return int.from_bytes(self._consume(1 << (info - 24)), "big")

    def _count(self, number: int) -> int:
        if number > len(self._payload) - self.at:  # each has at least a byte
            raise WireError("CBOR ends too early", self._payload)
        return number

    def _inner(self, depth: int) -> object:
        value = self.item(depth - 1)
        if value is _BREAK:
            raise WireError("CBOR has a break that ends nothing", self._payload)
        return value

    def _pair(self, depth: int) -> tuple[object, object]:
        return self._key(self._inner(depth)), self._inner(depth)

    def _key(self, key: object) -> str | int:
        if isinstance(key, bool) or not isinstance(key, (str, int)):
            raise WireError(f"CBOR has a key that is a {type(key).__name__}", self._payload)
        return key

    def _simple(self, info: int) -> object:
        if info == _INDEFINITE:
            return _BREAK
        if layout := _FLOATS.get(info):
            number = float(struct.unpack(layout, self._consume(struct.calcsize(layout)))[0])
            return number if math.isfinite(number) else None
        if info == 24:
            self._consume(1)
            return None
        if info > 27:
            raise WireError(f"CBOR has the reserved information {info}", self._payload)
        return {20: False, 21: True}.get(info)

    def _indefinite(self, major: int, depth: int) -> object:
        if major == 5:
            pairs: dict[object, object] = {}
            while (key := self.item(depth - 1)) is not _BREAK:
                pairs[self._key(key)] = self._inner(depth)
            return pairs
        items: list[object] = []
        while (value := self.item(depth - 1)) is not _BREAK:
            if major != 4 and not isinstance(value, str):
                raise WireError(f"CBOR has a {type(value).__name__} in a string", self._payload)
            items.append(value)
        return items if major == 4 else "".join(map(str, items))


def _text(encoded: bytes) -> str:
    try:
        return encoded.decode()
    except UnicodeDecodeError:
        raise WireError("CBOR has a text that is not UTF-8", encoded) from None
