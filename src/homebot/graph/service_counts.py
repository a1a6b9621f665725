"""Counters of late answers and refused calls of all services."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from homebot.clock import Clock
from homebot.errors import HomebotError
from homebot.graph.failures import Failures
from homebot.log import LogLimit, more_like_this
from homebot.support.isolation import error_text
from homebot.support.logger import get_logger

__all__ = ["ServiceCounts", "ServiceReports"]

ANSWER_LATE = "graph.answer_late"


@final
class ServiceCounts:
    """Counters of all services of a graph.

    Attributes:
        late_answers: Number of responses and errors that were dropped because their caller had left.
        refused_calls: Number of calls refused because the waiting line was full.
    """

    def __init__(self, clock: Clock) -> None:
        self.late_answers = 0
        self.refused_calls = 0
        self._limit = LogLimit(clock)

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


@final
@dataclass(frozen=True, slots=True, eq=False)
class ServiceReports:
    """Records the failures and late answers of one service."""

    node: str
    service: str
    failures: Failures
    counts: ServiceCounts

    def report_failure(self, error: Exception, *, has_caller: bool) -> None:
        """Record an unexpected *error* of the handler; *has_caller* if a caller receives it."""
        cost = "its caller gets the error" if has_caller else "its caller had left"
        self.failures.record(self.node, f"handler of {self.service}", error, cost)

    def report_late(self, error: HomebotError | None) -> None:
        """Record a late answer: an *error*, or None for a response."""
        self.counts.count_late(self.node, self.service, error)

    def report_refusal(self) -> None:
        """Record a call refused because the line was full."""
        self.counts.refused_calls += 1
