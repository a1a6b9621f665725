"""Report of a house when its test fails."""

from __future__ import annotations

from datetime import UTC, datetime
from itertools import islice

from homebot.testing.house import TestHouse

__all__ = ["house_report"]

LINES = 40


def house_report(house: TestHouse) -> str:
    """Return the time in *house*, what crashed, and the newest 40 lines of its log."""
    now = datetime.fromtimestamp(house.runtime.graph.clock.now(), UTC)
    events = house.log.events
    newest = list(islice(reversed(events), LINES))[::-1]
    older = house.log.lost + len(events) - len(newest)
    return "\n".join(
        [
            f"it is {now:%Y-%m-%d %H:%M:%S} UTC in the house; crashed: {', '.join(house.crashed) or 'nothing'}",
            *([f"({older} older events: house.log)"] if older else []),
            *(str(event) for event in newest),
        ]
    )
