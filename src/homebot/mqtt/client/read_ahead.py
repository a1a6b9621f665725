"""Bytes that were read from a socket before there was time to understand them. Pure.

A broker sends all the messages it keeps at once, and some drop what the socket does not take in time. So bytes are
taken from the socket as fast as they come, and understood in portions.
"""

from __future__ import annotations

from collections import deque
from typing import final

__all__ = ["ReadAhead"]


@final
class ReadAhead:
    """Bytes in order, bounded by who fills it: see :attr:`is_full`.

    Args:
        portion: How many bytes to hand out at once, at most.
        most: How many bytes make it full.

    Attributes:
        size: How many bytes wait.
    """

    def __init__(self, portion: int, most: int) -> None:
        self._portion = portion
        self._most = most
        self._chunks: deque[memoryview] = deque()
        self.size = 0

    @property
    def is_full(self) -> bool:
        """True if nothing more should be read for now."""
        return self.size >= self._most

    def put(self, data: bytes) -> None:
        """Add *data* at the end."""
        self._chunks.append(memoryview(data))
        self.size += len(data)

    def take(self) -> bytes:
        """Remove and return the next portion; empty when nothing waits."""
        if not self._chunks:
            return b""
        chunk = self._chunks.popleft()
        portion = bytes(chunk[: self._portion])
        if len(chunk) > self._portion:
            self._chunks.appendleft(chunk[self._portion :])
        self.size -= len(portion)
        return portion
