"""``homebot topic hz``."""

from __future__ import annotations

import argparse
import math
import sys
from collections import deque
from collections.abc import Sequence

import anyio

from homebot.cli.directory import WAITING, no_such_topic, topic_type
from homebot.cli.door_client import DoorClient
from homebot.cli.with_client import with_client

__all__ = ["hz", "rate_text"]

_INTERVAL = 1.0  # seconds between two lines


def hz(options: argparse.Namespace) -> int:
    """Print once a second how often a topic was published on, until Ctrl-C."""

    async def run(door: DoorClient) -> int:
        await door.subscribe(options.topic)
        if not await topic_type(door, options.topic):
            print(f"homebot: {await no_such_topic(door, options.topic)}\n{WAITING}", file=sys.stderr)
        await door.skip_kept()  # it says nothing about the rate
        times: deque[float] = deque(maxlen=options.window + 1)
        while True:
            seen = len(times), times[-1] if times else 0.0
            with anyio.move_on_after(_INTERVAL):
                while True:
                    await door.next()
                    times.append(anyio.current_time())
            is_new = (len(times), times[-1] if times else 0.0) != seen
            print(rate_text(times) if is_new and len(times) > 1 else "no new messages", flush=True)

    return with_client(options, run)


def rate_text(times: Sequence[float]) -> str:
    """Return the average rate of at least two arrival *times*, in seconds, with the spread of the gaps."""
    gaps = [later - earlier for earlier, later in zip(times, list(times)[1:], strict=False)]
    mean = sum(gaps) / len(gaps)
    deviation = math.sqrt(sum((gap - mean) ** 2 for gap in gaps) / len(gaps))
    rate = 1 / mean if mean > 0 else math.inf
    return (
        f"average rate: {rate:.3f}\n"
        f"\tmin: {min(gaps):.3f}s max: {max(gaps):.3f}s std dev: {deviation:.5f}s window: {len(times)}"
    )
