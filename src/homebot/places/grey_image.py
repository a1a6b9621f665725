"""Grey values of PGM and PNG images. Pure.

Sources: https://netpbm.sourceforge.net/doc/pgm.html and https://www.w3.org/TR/png-3/.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable
from typing import NamedTuple

from homebot.errors import UsageError

__all__ = ["MOST_PIXELS", "GreyImage", "read_grey_image"]

MOST_PIXELS = 16_000_000

_PNG = b"\x89PNG\r\n\x1a\n"
_PGM = re.compile(rb"(P[25])(?:\s|#[^\n]*\n)+(\d{1,6})(?:\s|#[^\n]*\n)+(\d{1,6})(?:\s|#[^\n]*\n)+(\d{1,5})\s")
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_PALETTE = 3


class GreyImage(NamedTuple):
    """An image, row by row from the top.

    Attributes:
        width: Columns.
        height: Rows.
        grey: The mean of the colours of each pixel, 0 to 255.
        alpha: The opacity of each; empty if all are opaque.
    """

    width: int
    height: int
    grey: bytes
    alpha: bytes = b""


def read_grey_image(content: bytes) -> GreyImage:
    """Return the grey values of a PGM or PNG file.

    Raises:
        UsageError: It is none, is damaged, or has more than 16 million pixels.
    """
    if content.startswith(_PNG):
        return _png(content)
    if (head := _PGM.match(content)) is not None:
        return _pgm(content[head.end() :], head[1] == b"P5", int(head[2]), int(head[3]), int(head[4]))
    raise UsageError("is no image that is known; a map's image is a PGM (P2 or P5) or a PNG file")


def _pgm(body: bytes, is_binary: bool, width: int, height: int, most: int) -> GreyImage:  # noqa: FBT001 - of one caller
    count = _pixels(width, height)
    if not 0 < most < 2**16:
        raise UsageError(f"has the largest value {most}; it is from 1 to 65535")
    if not is_binary:
        values = [*map(int, re.sub(rb"#[^\n]*", b"", body).split()[:count])]
    elif most > 255:
        values = [high << 8 | low for high, low in zip(body[: 2 * count : 2], body[1 : 2 * count : 2], strict=False)]
    else:
        values = [*body[:count]]
    if len(values) < count:
        raise UsageError(f"is cut: it has {len(values):,} of {count:,} pixels")
    return GreyImage(width, height, bytes(min(one, most) * 255 // most for one in values))


def _pixels(width: int, height: int) -> int:
    if not 0 < width * height <= MOST_PIXELS:
        raise UsageError(f"has {width:,} × {height:,} pixels; {MOST_PIXELS:,} is the limit")  # noqa: RUF001 - times
    return width * height


def _png(content: bytes) -> GreyImage:
    chunks = _chunks(content)
    head = chunks.get(b"IHDR", b"")
    if len(head) != 13:
        raise UsageError("is a damaged PNG file")
    width, height = int.from_bytes(head[:4], "big"), int.from_bytes(head[4:8], "big")
    depth, kind, interlaced = head[8], head[9], head[12]
    _pixels(width, height)
    if interlaced or kind not in _CHANNELS or depth not in {1, 2, 4, 8, 16}:
        raise UsageError("is an interlaced or unknown kind of PNG file; save it again without interlacing")
    bits = depth * _CHANNELS[kind]
    size = (width * bits + 7) // 8
    try:
        data = zlib.decompressobj().decompress(chunks.get(b"IDAT", b""), (size + 1) * height)
    except zlib.error as exc:
        raise UsageError(f"is a damaged PNG file: {exc}") from exc
    if len(data) < (size + 1) * height:
        raise UsageError("is a damaged PNG file: it is cut")
    rows = _unfiltered(data, size, max(1, bits // 8))
    samples = b"".join(_samples(row, depth, kind, width * _CHANNELS[kind]) for row in rows)
    return _grey(width, height, samples, kind, chunks)


def _grey(width: int, height: int, samples: bytes, kind: int, chunks: dict[bytes, bytes]) -> GreyImage:
    if kind == _PALETTE:
        palette, clear = chunks.get(b"PLTE", b""), chunks.get(b"tRNS", b"")
        means = bytes(sum(palette[3 * one : 3 * one + 3]) // 3 for one in range(256))
        alpha = samples.translate(clear + b"\xff" * (256 - len(clear))) if clear else b""
        return GreyImage(width, height, samples.translate(means), alpha)
    step = _CHANNELS[kind]
    alpha = samples[step - 1 :: step] if step in {2, 4} else b""
    if step < 3:
        return GreyImage(width, height, samples[::step], alpha)
    colours = zip(samples[::step], samples[1::step], samples[2::step], strict=True)
    return GreyImage(width, height, bytes((r + g + b) // 3 for r, g, b in colours), alpha)


def _chunks(content: bytes) -> dict[bytes, bytes]:
    found: dict[bytes, bytes] = {}
    parts: list[bytes] = []
    start = len(_PNG)
    while start + 8 <= len(content):
        size, name = int.from_bytes(content[start : start + 4], "big"), content[start + 4 : start + 8]
        body = content[start + 8 : start + 8 + size]
        found[name] = body
        if name == b"IDAT":
            parts.append(body)
        start += size + 12
    return found | {b"IDAT": b"".join(parts)}


def _samples(row: bytes, depth: int, kind: int, count: int) -> bytes:
    """Return the samples of a row as bytes."""
    if depth >= 8:
        return row if depth == 8 else row[::2]
    most, scale = (1 << depth) - 1, 1 if kind == _PALETTE else 255 // ((1 << depth) - 1)
    each = range(8 - depth, -1, -depth)
    return bytes((byte >> shift & most) * scale for byte in row for shift in each)[:count]


def _unfiltered(data: bytes, size: int, step: int) -> list[bytes]:
    """Return the rows of an image, without the filters of PNG."""
    rows: list[bytes] = []
    above = bytes(size)
    for start in range(0, len(data), size + 1):
        kind, row = data[start], bytearray(data[start + 1 : start + 1 + size])
        if kind == 2:
            row = bytearray((one + up) & 255 for one, up in zip(row, above, strict=True))
        elif kind:
            guess = _FILTERS.get(kind)
            if guess is None:
                raise UsageError("is a damaged PNG file: it has an unknown filter")
            for index in range(size):
                left, corner = (row[index - step], above[index - step]) if index >= step else (0, 0)
                row[index] = (row[index] + guess(left, above[index], corner)) & 255
        above = bytes(row)
        rows.append(above)
    return rows


def _paeth(left: int, up: int, corner: int) -> int:
    guess = left + up - corner
    return min((left, up, corner), key=lambda one: abs(guess - one))


_FILTERS: dict[int, Callable[[int, int, int], int]] = {
    1: lambda left, _up, _corner: left,
    3: lambda left, up, _corner: (left + up) // 2,
    4: _paeth,
}
