"""Long JSON, parsed while other tasks run."""

from typing import Final

import anyio.lowlevel

from homebot.conventions.long_json import parse_in_slices

_TURN: Final = 64 * 1024
"""Characters that are parsed before other tasks get their turn; a longer member is parsed without a pause."""


async def parse_long_json(payload: bytes, limit: int) -> object:
    """Return *payload*, parsed as JSON; other tasks run in between.

    A worker thread would not help: `json` holds the interpreter's lock for as long as it parses.

    Raises:
        WireError: It is longer than *limit* bytes, or as :func:`homebot.conventions.payload.parse_json`.
    """
    slices = parse_in_slices(payload, limit)
    pause_at = _TURN
    while True:
        try:
            parsed = next(slices)
        except StopIteration as done:
            value: object = done.value
            return value
        if parsed >= pause_at:
            pause_at = parsed + _TURN
            await anyio.lowlevel.checkpoint()
