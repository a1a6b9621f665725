"""Numbers as bytes: columns of machine numbers, with bytes of equal significance grouped, zlib level 1. Pure.

The first byte is the version of the format. Neighbours are similar in most bytes, so each takes only a few bits.
"""

from __future__ import annotations

import math
import sys
import zlib
from array import array
from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import Any, Final

from homebot.errors import WireError
from homebot.features.history.buckets import Bucket

_VERSION: Final = b"\x01"
_LEVEL: Final = 1
_COLUMNS: Final = "ddfdff"
"""The type codes of the columns of buckets: a mean needs no more digits."""

_NONE: Final = Bucket(math.nan, math.nan, math.nan, math.nan, 0.0, 0.0)


def encode_values(start: int, times: Sequence[int], values: Sequence[float]) -> bytes:
    """Return *values* and their non-decreasing *times*, in milliseconds since *start*, as bytes."""
    steps = (after - before for before, after in zip((start, *times[:-1]), times, strict=True))
    return _pack(array("I", steps), array("d", values))


def decode_values(start: int, data: bytes) -> tuple[array[int], array[float]]:
    """Return the times and values in *data*.

    Raises:
        WireError: *data* is not from :func:`encode_values`.
    """
    steps, values = _unpack(data, "Id")
    return array("q", list(accumulate(steps, initial=start))[1:]), values


def encode_buckets(buckets: Mapping[int, Bucket], first: int, count: int) -> bytes:
    """Return the *buckets* from number *first* on, up to *count*, as bytes; some may be missing."""
    rows = [buckets.get(number, _NONE) for number in range(first, first + count)]
    return _pack(*(array(letter, column) for letter, column in zip(_COLUMNS, zip(*rows, strict=True), strict=True)))


def decode_buckets(first: int, data: bytes) -> dict[int, Bucket]:
    """Return the buckets in *data*; the first one has the number *first*.

    Raises:
        WireError: *data* is not from :func:`encode_buckets`.
    """
    columns = _unpack(data, _COLUMNS)
    rows = map(Bucket._make, zip(*columns, strict=True))
    return {number: row for number, row in enumerate(rows, first) if row.seconds > 0}


def encode_batch(series: array[int], times: array[int], values: array[float]) -> bytes:
    """Return values of several *series*, with their times in milliseconds since the Unix epoch, as bytes."""
    return _pack(series, times, values)


def decode_batch(data: bytes) -> tuple[array[int], array[int], array[float]]:
    """Return series, times and values in *data*.

    Raises:
        WireError: *data* is not from :func:`encode_batch`.
    """
    series, times, values = _unpack(data, "Hqd")
    return series, times, values


def _pack(*columns: array[Any]) -> bytes:
    pieces = []
    for column in columns:
        size, data = column.itemsize, _little(column).tobytes()
        pieces += [data[place::size] for place in range(size)]
    return _VERSION + zlib.compress(b"".join(pieces), _LEVEL)


def _unpack(data: bytes, letters: str) -> list[Any]:
    sizes = [array(letter).itemsize for letter in letters]
    try:
        plain = zlib.decompress(data[1:]) if data[:1] == _VERSION else b"?"
    except zlib.error:
        plain = b"?"
    count, rest = divmod(len(plain), sum(sizes))
    if rest:
        raise WireError("the numbers of the history cannot be read", data[:20])
    columns: list[Any] = []
    begin = 0
    for letter, size in zip(letters, sizes, strict=True):
        mixed = bytearray(count * size)
        for place in range(size):
            mixed[place::size] = plain[begin : begin + count]
            begin += count
        column: array[Any] = array(letter)
        column.frombytes(bytes(mixed))
        columns.append(_little(column))
    return columns


def _little(column: array[Any]) -> array[Any]:
    """Return *column* with swapped bytes if this computer is big-endian."""
    if sys.byteorder == "big":
        column = column[:]
        column.byteswap()
    return column
