"""Long JSON, parsed while other tasks run."""

from __future__ import annotations

import anyio.lowlevel

from homebot.conventions.long_json import parse_in_slices

__all__ = ["parse_long_json"]


async def parse_long_json(payload: bytes, limit: int) -> object:
    """Return what *payload* says in JSON; the event loop goes on after each 64 KiB.

    A worker thread would not help: `json` holds the interpreter's lock for as long as it parses.

    Raises:
        WireError: It is longer than *limit* bytes, or as :func:`homebot.conventions.payload.parse_json`.
    """
    slices = parse_in_slices(payload, limit)
    while True:
        try:
            next(slices)
        except StopIteration as done:
            value: object = done.value
            return value
        await anyio.lowlevel.checkpoint()
