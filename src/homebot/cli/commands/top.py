"""``homebot top``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Final, cast

from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import is_terminal, print_line, print_table, rich_terminal

HEADINGS: Final = ("TOPIC", "MSG/S", "WAITING", "LOST", "SLOWEST", "BY")
_MILLI: Final = 1000.0
_FRAME: Final = 0.5
_SAMPLE: Final = 1.0
_SORTED_EVERY: Final = 10
"""Frames after which topics are sorted again, so that lines do not jump."""

_EXAMPLES = """\
  homebot top
  homebot top --json | jq .lag

For each topic: messages per second, the number waiting in its fullest queue, the number lost since the start, and the
time of its slowest handler since the last frame. On a terminal it runs until Ctrl-C; elsewhere it prints one table.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _top, _EXAMPLES)
    parser.add_argument("--json", action="store_true", help="print a JSON object every second until Ctrl-C")


def samples(ask: Callable[[], dict[str, object]], wait: Callable[[], None]) -> Iterator[Load]:
    """Yield the load since the previous sample, forever."""
    before = ask()
    while True:
        wait()
        after = ask()
        yield Load.between(before, after)
        before = after


def _top(door: DoorClient, options: argparse.Namespace) -> int:
    is_live = is_terminal() and not options.json

    def wait() -> None:
        for _ in door.until(_FRAME if is_live else _SAMPLE):
            pass

    loads = samples(lambda: door.call("/rosapi/load"), wait)
    if is_live:
        frames = _frames(loads, f"{door.home} on {door.where}")
        rich_terminal(sys.stdout).show_live(HEADINGS, frames, if_wide=("BY", "SLOWEST", "WAITING"))
        return 0
    for load in loads:
        if not options.json:
            print_table(HEADINGS, [row.cells() for row in load.rows])
            print_line(load.title)
            break
        print(json.dumps(load.as_json()), flush=True)
    return 0


def _frames(loads: Iterator[Load], where: str) -> Iterator[tuple[str, list[tuple[str, ...]]]]:
    order: list[str] = []
    for number, load in enumerate(loads):
        if number % _SORTED_EVERY == 0:
            order = [row.topic for row in load.rows]
        yield f"{where}: {load.title}", [row.cells() for row in load.in_order_of(order)]


@dataclass(frozen=True, slots=True)
class TopicRow:
    """One topic.

    Attributes:
        rate: Messages per second.
        waiting: Messages in the fullest queue.
        lost: Messages lost since the start.
        slowest: The longest run of a handler since the previous sample, in seconds.
        by: The node of that handler, or of the fullest queue if none was called.
    """

    topic: str
    rate: float
    waiting: int
    lost: int
    slowest: float
    by: str

    def cells(self) -> tuple[str, ...]:
        """Return the columns as text, with numbers of constant width."""
        slowest = f"{self.slowest * _MILLI:8.1f} ms" if self.slowest else f"{'':11}"
        return self.topic, f"{self.rate:8.1f}", f"{self.waiting:7}", f"{self.lost:8}", slowest, self.by.lstrip("/")


@dataclass(frozen=True, slots=True)
class Load:
    """The load between two answers of ``/rosapi/load``.

    Attributes:
        lag: The longest delay of the event loop, in seconds.
        rows: The topics, busiest first.
    """

    lag: float
    rows: tuple[TopicRow, ...]

    @classmethod
    def between(cls, before: Mapping[str, object], after: Mapping[str, object]) -> Load:
        """Return the load between two answers."""
        seconds = max(_number(after, "at") - _number(before, "at"), 0.001)
        old = {str(entry["topic"]): _number(entry, "published") for entry in _list(before, "topics")}
        queues: dict[str, list[Mapping[str, object]]] = {}
        for entry in _list(after, "queues"):
            queues.setdefault(str(entry["topic"]), []).append(entry)
        rows = []
        for entry in _list(after, "topics"):
            topic, published = str(entry["topic"]), _number(entry, "published")
            rate = max(0.0, published - old.get(topic, published)) / seconds
            rows.append(_row(topic, rate, queues.get(topic, [])))
        ordered = sorted(rows, key=lambda row: (-row.rate, -row.waiting, -row.lost, row.topic))
        return cls(_number(after, "lag"), tuple(ordered))

    @property
    def title(self) -> str:
        """The total load in one line."""
        rate, lost = sum(row.rate for row in self.rows), sum(row.lost for row in self.rows)
        waiting = sum(row.waiting for row in self.rows)
        return f"{rate:.1f} messages/s, {waiting} waiting, {lost} lost; loop lag {self.lag * _MILLI:.1f} ms"

    def in_order_of(self, topics: Sequence[str]) -> tuple[TopicRow, ...]:
        """Return the rows in the order of *topics*, followed by all others."""
        places = {topic: place for place, topic in enumerate(topics)}
        return tuple(sorted(self.rows, key=lambda row: places.get(row.topic, len(places))))

    def as_json(self) -> dict[str, object]:
        """Return a JSON object, with times in seconds."""
        return {"lag": self.lag, "topics": [asdict(row) for row in self.rows]}


def _row(topic: str, rate: float, queues: Sequence[Mapping[str, object]]) -> TopicRow:
    most = max(queues, key=lambda queue: (_number(queue, "slowest"), _number(queue, "waiting")), default={})
    return TopicRow(
        topic,
        rate,
        int(max((_number(queue, "waiting") for queue in queues), default=0)),
        int(sum(_number(queue, "lost") for queue in queues)),
        _number(most, "slowest"),
        str(most.get("node", "")),
    )


def _number(answer: Mapping[str, object], name: str) -> float:
    return cast("float", answer.get(name, 0))


def _list(answer: Mapping[str, object], name: str) -> list[Mapping[str, object]]:
    return cast("list[Mapping[str, object]]", answer[name])
