"""Rows of ``homebot top`` from two measurements of the load. Pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Final, cast

__all__ = ["HEADINGS", "Load", "TopicRow"]

HEADINGS: Final = ("TOPIC", "MSG/S", "WAITING", "LOST", "SLOWEST", "BY")
_MILLI: Final = 1000.0


@dataclass(frozen=True, slots=True)
class TopicRow:
    """One topic.

    Attributes:
        rate: Messages in a second.
        waiting: Messages that wait in the fullest queue.
        lost: Messages that were lost since the start.
        slowest: Seconds that a handler needed at most since the sample before.
        by: The node of that handler; of the fullest queue if none was called.
    """

    topic: str
    rate: float
    waiting: int
    lost: int
    slowest: float
    by: str

    def cells(self) -> tuple[str, ...]:
        """Return the columns as text, numbers of a constant width."""
        slowest = f"{self.slowest * _MILLI:8.1f} ms" if self.slowest else f"{'':11}"
        return self.topic, f"{self.rate:8.1f}", f"{self.waiting:7}", f"{self.lost:8}", slowest, self.by.lstrip("/")


@dataclass(frozen=True, slots=True)
class Load:
    """The load between two answers of ``/rosapi/load``.

    Attributes:
        lag: Seconds by which the event loop was late at most.
        rows: The topics, the busiest first.
    """

    lag: float
    rows: tuple[TopicRow, ...]

    @classmethod
    def between(cls, before: Mapping[str, object], after: Mapping[str, object]) -> Load:
        """Return the load between two answers."""
        seconds = max(_number(after, "at") - _number(before, "at"), 0.001)
        old = {str(one["topic"]): _number(one, "published") for one in _list(before, "topics")}
        queues: dict[str, list[Mapping[str, object]]] = {}
        for one in _list(after, "queues"):
            queues.setdefault(str(one["topic"]), []).append(one)
        rows = []
        for one in _list(after, "topics"):
            topic, published = str(one["topic"]), _number(one, "published")
            rate = max(0.0, published - old.get(topic, published)) / seconds
            rows.append(_row(topic, rate, queues.get(topic, [])))
        ordered = sorted(rows, key=lambda row: (-row.rate, -row.waiting, -row.lost, row.topic))
        return cls(_number(after, "lag"), tuple(ordered))

    @property
    def title(self) -> str:
        """The load of everything in a line."""
        rate, lost = sum(one.rate for one in self.rows), sum(one.lost for one in self.rows)
        waiting = sum(one.waiting for one in self.rows)
        return f"{rate:.1f} messages/s, {waiting} waiting, {lost} lost; loop lag {self.lag * _MILLI:.1f} ms"

    def in_order_of(self, topics: Sequence[str]) -> tuple[TopicRow, ...]:
        """Return the rows in the order of *topics*, then those of others."""
        places = {topic: place for place, topic in enumerate(topics)}
        return tuple(sorted(self.rows, key=lambda one: places.get(one.topic, len(places))))

    def as_json(self) -> dict[str, object]:
        """Return a JSON object; seconds for times."""
        return {"lag": self.lag, "topics": [asdict(one) for one in self.rows]}


def _row(topic: str, rate: float, queues: Sequence[Mapping[str, object]]) -> TopicRow:
    most = max(queues, key=lambda one: (_number(one, "slowest"), _number(one, "waiting")), default={})
    return TopicRow(
        topic,
        rate,
        int(max((_number(one, "waiting") for one in queues), default=0)),
        int(sum(_number(one, "lost") for one in queues)),
        _number(most, "slowest"),
        str(most.get("node", "")),
    )


def _number(answer: Mapping[str, object], name: str) -> float:
    return cast("float", answer.get(name, 0))


def _list(answer: Mapping[str, object], name: str) -> list[Mapping[str, object]]:
    return cast("list[Mapping[str, object]]", answer[name])
