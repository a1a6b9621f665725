"""Text frames in the form that a client sends or requests: in fragments, or as a PNG image. Pure.

Source: RobotWebTools rosbridge_suite, ROSBRIDGE_PROTOCOL.md, sections 3.1.1 and 3.1.2; for what is not specified, the
layout of the image, its ``pngcompression.py``: a square of RGB, filled up with line feeds.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from base64 import b64encode
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import Final, final

from homebot.bridges.rosbridge.protocol import Fragment, FrameError, Identifier, Operation, Request, parse_frame

_MAX_OPEN: Final = 10

_MAX_FRAGMENTS: Final = 1000
_PIXEL: Final = 3  # bytes
_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_RGB: Final = bytes((8, 2, 0, 0, 0))  # 8 bits of a colour; deflate; filters by row; not interlaced
_FAST: Final = 1
_LARGEST_IMAGE: Final = 1_048_576  # characters: about 10 ms of uninterrupted work


@dataclass(frozen=True, slots=True)
class Packing:
    """The form of text frames for a client.

    Attributes:
        as_png: Whether each is sent as an image, except above a megabyte; every client also reads JSON.
        fragment_size: Characters of a fragment, more if there would be above 1000 fragments; shorter frames are sent
            whole, as all are if it is below 1.
    """

    as_png: bool = False
    fragment_size: int = 0

    @classmethod
    def of(cls, op: Request) -> Packing:
        """Return the form of the answers to *op*."""
        return cls(op.compression == "png", op.fragment_size or 0)

    def pack(self, text: str, identifier: str) -> Iterator[str]:
        """Yield the frames for *text*; *identifier* separates its fragments from those of others."""
        if self.as_png and len(text) <= _LARGEST_IMAGE:
            text = _frame({"op": "png", "data": b64encode(_image(text.encode())).decode()})
        if not 0 < self.fragment_size < len(text):
            yield text
            return
        size = max(self.fragment_size, math.ceil(len(text) / _MAX_FRAGMENTS))
        total = math.ceil(len(text) / size)
        for number in range(total):
            data = text[number * size : (number + 1) * size]
            yield _frame({"op": "fragment", "id": identifier, "data": data, "num": number, "total": total})


PLAIN: Final = Packing()
"""Whole frames, as JSON."""


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


@final
class FrameAssembler:
    """The reader of operations, which assembles fragments received in any order.

    It keeps the fragments of up to ten incomplete frames; an eleventh replaces the oldest.

    Args:
        limit: Most characters of all fragments; one outside ASCII makes all of its fragment count fourfold.
        hold: Called with each change of their number.
    """

    def __init__(self, limit: int, hold: Callable[[int], None]) -> None:
        self.dropped = 0
        self._limit, self._hold, self._held = limit, hold, 0
        self._open: dict[Identifier, _Collected] = {}

    def read(self, frame: str) -> Generator[None, None, Operation | None]:
        """Return the operation in *frame*; None if it is a fragment and others are missing.

        Other tasks may run between its steps.
        """
        op = yield from parse_frame(frame)
        if not isinstance(op, Fragment):
            return op
        try:
            whole = self._collect(op)
        finally:
            size = sum(unfinished.size for unfinished in self._open.values())
            self._hold(size - self._held)
            self._held = size
        if whole is None:
            return None
        op = yield from parse_frame(whole)
        if isinstance(op, Fragment):
            raise FrameError("a fragment cannot be made of fragments", op.op, op.id)
        return op

    def _collect(self, fragment: Fragment) -> str | None:
        collected = self._open.pop(fragment.id, None) or _Collected(fragment.total)
        if fragment.total != collected.total or fragment.num >= fragment.total:
            raise FrameError(f"number {fragment.num} of {fragment.total} does not fit", fragment.op, fragment.id)
        collected.add(fragment)
        if collected.size + sum(unfinished.size for unfinished in self._open.values()) > self._limit:
            raise FrameError(f"the fragments have more than {self._limit:,} characters", fragment.op, fragment.id)
        if len(collected.parts) == collected.total:
            return "".join(part for _, part in sorted(collected.parts.items()))
        self._open[fragment.id] = collected
        if len(self._open) > _MAX_OPEN:
            del self._open[next(iter(self._open))]
            self.dropped += 1
        return None


class _Collected:
    def __init__(self, total: int) -> None:
        self.total = total
        self.size = 0
        self.parts: dict[int, str] = {}

    def add(self, fragment: Fragment) -> None:
        self.size += _size(fragment.data) - _size(self.parts.get(fragment.num, ""))
        self.parts[fragment.num] = fragment.data


def _size(text: str) -> int:
    return len(text) * (1 if text.isascii() else 4)
