"""Counts of service calls that did not end as they should, on the whole graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from homebot.clock import Clock
from homebot.errors import HomebotError
from homebot.graph.failures import Failures
from homebot.isolation import error_text
from homebot.log import LogLimit, more_like_this
from homebot.logger import get_logger

__all__ = ["ServiceCounts", "ServiceReports"]

ANSWER_LATE = "graph.answer_late"


@final
class ServiceCounts:
    """Counters of all services of a graph.

    Args:
        clock: The time to go by.

    Attributes:
        late_answers: Answers, errors among them, that came when their caller had left; they were dropped.
        refused_calls: Calls that were refused because too many wait for the service.
    """

    def __init__(self, clock: Clock) -> None:
        self.late_answers = 0
        self.refused_calls = 0
        self._limit = LogLimit(clock)

    def count_late(self, node: str, service: str, error: HomebotError | None) -> None:
        """Count a late answer; a line of the log says which *error* it is, at most one in 10 s for each service."""
        self.late_answers += 1
        held_back = self._limit.allows(service) if error is not None else None
        if error is None or held_back is None:
            return
        get_logger(node=node).warning(
            ANSWER_LATE,
            message=f"{service} failed when its caller had left ({error_text(error)}){more_like_this(held_back)}",
            service=service,
        )


@final
@dataclass(frozen=True, slots=True, eq=False)
class ServiceReports:
    """Takes the reports of one service.

    Attributes:
        node: Full name of the serving node.
        service: Full name of the service.
        failures: Counts failures of its handlers.
        counts: Counts the rest.
    """

    node: str
    service: str
    failures: Failures
    counts: ServiceCounts

    def report_failure(self, error: Exception, *, has_caller: bool) -> None:
        """Take an *error* of the handler that is no answer; *has_caller* says whether the caller gets it."""
        cost = "its caller gets the error" if has_caller else "its caller had left"
        self.failures.record(self.node, f"handler of {self.service}", error, cost)

    def report_late(self, error: HomebotError | None) -> None:
        """Take note of an answer, the *error* or a response, that came when its caller had left."""
        self.counts.count_late(self.node, self.service, error)

    def report_refusal(self) -> None:
        """Take note of a call that was refused because too many wait in line."""
        self.counts.refused_calls += 1
