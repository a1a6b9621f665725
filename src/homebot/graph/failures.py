"""Exceptions that callbacks of nodes let through: each costs its one message, and is logged and counted here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from homebot.clock import Clock
from homebot.isolation import error_text
from homebot.log import LogLimit, more_like_this
from homebot.logger import get_logger

__all__ = ["CallbackFailure", "Failures"]

CALLBACK_FAILED = "graph.callback_failed"

_MOST = 1000
_OTHERS = "other callbacks"


@final
@dataclass(slots=True)
class CallbackFailure:
    """The number of times one callback failed, and the last error.

    Attributes:
        node: Full name of its node.
        callback: Which one, in words: "handler of /topic".
        count: How often since the graph was made, over all starts of the node.
        last: The last error, in words.
        at: When that was, in seconds since the Unix epoch.
    """

    node: str
    callback: str
    count: int = 0
    last: str = ""
    at: float = 0.0


@final
class Failures:
    """The failed callbacks of all nodes of a graph; iterate over them.

    The first 1,000 are told apart, all others are one.

    Args:
        clock: The time to go by.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._limit = LogLimit(clock)
        self._failures: dict[tuple[str, str], CallbackFailure] = {}

    def __iter__(self) -> Iterator[CallbackFailure]:
        return iter(self._failures.values())

    def record(self, node: str, callback: str, error: Exception, cost: str) -> None:
        """Count one more *error* of *callback*; a line of the log says what it *cost*, at most one in 10 s for each."""
        failure = self._failure(node, callback)
        failure.count += 1
        failure.last = error_text(error)
        failure.at = self._clock.now()
        held_back = self._limit.allows(f"{node} {callback}")
        if held_back is None:
            return
        get_logger(node=node).error(
            CALLBACK_FAILED,
            message=f"the {callback} failed ({failure.last}); {cost}{more_like_this(held_back)}",
            callback=callback,
            failures=failure.count,
            exc_info=error,
        )

    def _failure(self, node: str, callback: str) -> CallbackFailure:
        key = (node, callback)
        if key not in self._failures and len(self._failures) >= _MOST:
            key = ("", _OTHERS)
        return self._failures.setdefault(key, CallbackFailure(*key))
