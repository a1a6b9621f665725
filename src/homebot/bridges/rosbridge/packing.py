"""Frames of text as a client asks for them: as a PNG image, in fragments. Pure.

Source: RobotWebTools rosbridge_suite, ROSBRIDGE_PROTOCOL.md, sections 3.1.1 and 3.1.2; for what is not specified, the
layout of the image, its ``pngcompression.py``: a square of RGB, filled up with line feeds.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

__all__ = ["PLAIN", "Packing"]

_MOST_FRAGMENTS: Final = 1000
_PIXEL: Final = 3  # bytes
_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_RGB: Final = bytes((8, 2, 0, 0, 0))  # 8 bits of a colour; deflate; filters by row; not interlaced
_FAST: Final = 1
_LARGEST_IMAGE: Final = 1_048_576  # characters; it takes about 10 ms, in which nothing else is done


@dataclass(frozen=True, slots=True)
class Packing:
    """The form in which frames of text go to a client.

    Attributes:
        as_png: Each is the content of an image, but those above a megabyte, which every client reads as JSON too.
        fragment_size: Characters of a fragment, more where there would be above 1000; a shorter frame is sent whole;
            below 1 each is.
    """

    as_png: bool = False
    fragment_size: int = 0

    def pack(self, text: str, identifier: str) -> Iterator[str]:
        """Yield the frames for *text*; *identifier* separates its fragments from those of others."""
        if self.as_png and len(text) <= _LARGEST_IMAGE:
            text = _frame({"op": "png", "data": b64encode(_image(text.encode())).decode()})
        if not 0 < self.fragment_size < len(text):
            yield text
            return
        size = max(self.fragment_size, math.ceil(len(text) / _MOST_FRAGMENTS))
        total = math.ceil(len(text) / size)
        for number in range(total):
            data = text[number * size : (number + 1) * size]
            yield _frame({"op": "fragment", "id": identifier, "data": data, "num": number, "total": total})


PLAIN: Final = Packing()
"""Each frame whole, as JSON."""


def _frame(fields: dict[str, str | int]) -> str:
    return json.dumps(fields, separators=(",", ":"))


def _image(content: bytes) -> bytes:
    width = max(1, math.isqrt(len(content) // _PIXEL))
    row = width * _PIXEL
    height = math.ceil(len(content) / row)
    content = content.ljust(row * height, b"\n")
    rows = b"".join(b"\0" + content[start : start + row] for start in range(0, len(content), row))
    header = struct.pack(">II", width, height) + _RGB
    return _SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(rows, _FAST)) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
