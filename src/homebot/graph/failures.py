"""Unhandled exceptions in callbacks, each of which costs only its message, and lost answers and calls."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from homebot.clock import Clock
from homebot.errors import HomebotError
from homebot.log import LogLimit, more_like_this
from homebot.support.isolation import Place, error_text, place_of
from homebot.support.logger import get_logger

CALLBACK_FAILED = "graph.callback_failed"
ANSWER_LATE = "graph.answer_late"

_MAX_SOURCES = 1000
_OTHERS = "other callbacks"


@final
@dataclass(slots=True)
class CallbackFailure:
    """The failures of one callback.

    Attributes:
        at: Time of the last error, in seconds since the Unix epoch.
        shown: The place of the error whose traceback was last logged.
    """

    node: str
    callback: str
    count: int = 0
    last: str = ""
    at: float = 0.0
    shown: Place | None = None


@final
class Failures:
    """The failed callbacks of all nodes of a graph; iterate over them.

    The first 1,000 callbacks have entries of their own; all others share one.

    Attributes:
        late_answers: Number of responses and errors that were dropped because their caller had left, and of results of
            goals that were not requested in time.
        messages_lost: Number of messages lost by subscriptions that are closed.
        refused_calls: Number of calls and goals refused because too many were waiting.
    """

    def __init__(self, clock: Clock) -> None:
        self.late_answers = 0
        self.messages_lost = 0
        self.refused_calls = 0
        self._clock = clock
        self._limit = LogLimit(clock)
        self._failures: dict[tuple[str, str], CallbackFailure] = {}

    def __iter__(self) -> Iterator[CallbackFailure]:
        return iter(self._failures.values())

    def record(self, node: str, callback: str, error: Exception, cost: str) -> None:
        """Count an *error* of *callback* and log it with its *cost*, at most one line in 10 s for both.

        The traceback is logged if the last one came from another place.
        """
        key = (node, callback)
        if key not in self._failures and len(self._failures) >= _MAX_SOURCES:
            key = ("", _OTHERS)
        failure = self._failures.setdefault(key, CallbackFailure(*key))
        failure.count += 1
        failure.last = error_text(error)
        failure.at = self._clock.now()
        held_back = self._limit.allows(f"{node} {callback} {cost}")
        if held_back is None:
            return
        trace = {} if failure.shown == place_of(error) else {"exc_info": error}
        failure.shown = place_of(error)
        get_logger(node=node).error(
            CALLBACK_FAILED,
            message=f"the {callback} failed ({failure.last}); {cost}{more_like_this(held_back)}",
            callback=callback,
            failures=failure.count,
            **trace,
        )

    def count_late(self, node: str, service: str, error: HomebotError | None) -> None:
        """Count a late answer and log an *error*, at most one line in 10 s for each service."""
        self.late_answers += 1
        held_back = self._limit.allows(service) if error is not None else None
        if error is None or held_back is None:
            return
        get_logger(node=node).warning(
            ANSWER_LATE,
            message=f"{service} failed when its caller had left ({error_text(error)}){more_like_this(held_back)}",
            service=service,
        )
