"""What counts as time in which a thread got no processor."""

from __future__ import annotations

import threading

import pytest

from homebot.starvation import StarvedTime, queued_seconds


@pytest.mark.parametrize(
    ("now", "used", "queued", "expected"),
    [
        (10.25, 1.0, 0.0, 0.0),
        (10.25, 1.25, 0.0, 0.0),
        (12.25, 1.0, 0.0, 2.0),
        (12.25, 1.25, 0.0, 2.0),
        (12.25, 1.5, 0.0, 1.75),
        (10.25, 1.0, 0.2, 0.2),
        (12.25, 1.0, 2.0, 2.0),
    ],
    ids=[
        "it waits",
        "it works",
        "it was stopped",
        "it worked and was stopped",
        "it was stopped and works",
        "others had the processor",
        "told by both",
    ],
)
def test_what_one_look_adds(now: float, used: float, queued: float, expected: float) -> None:
    starved = StarvedTime(interval=0.25)
    starved.look(10.0, 1.0, 0.0)
    starved.look(now, used, queued)
    assert starved.seconds == pytest.approx(expected)


def test_the_system_counts_for_each_thread_or_not_at_all() -> None:
    first = queued_seconds(threading.get_native_id())
    assert 0 <= first <= queued_seconds(threading.get_native_id())
    assert queued_seconds(2**30) == 0
