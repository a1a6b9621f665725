"""The health of the link to robots: refusals, losses, and types that differ on both sides."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.support.counters import Severity

_MAX_SHOWN = 20

NOT_IMPORTED = "ros2.not_imported"
MESSAGE_REFUSED = "ros2.message_refused"
CALL_REFUSED = "ros2.call_refused"


class LinkHealth:
    """Logs each kind of problem at a limited rate, counts all, and tells ``homebot doctor`` of them."""

    def __init__(self, node: Node) -> None:
        self._node, self._each = node, LogLimit(node.graph.clock)
        self._all = LogLimit(node.graph.clock, burst=_MAX_SHOWN)
        self._refused = Counter({MESSAGE_REFUSED: 0, CALL_REFUSED: 0, NOT_IMPORTED: 0})

    def refused(self, event: str, subject: str, problem: str) -> None:
        """Count a refusal."""
        self._refused[event] += 1
        if self._each.allows(f"{event} {subject}") is None or (held_back := self._all.allows(event)) is None:
            return
        self._node.log.warning(event, subject=subject[:200], problem=problem[:500], held_back=held_back)

    def serve(
        self, lost: Callable[[], int], problems: Callable[[], Iterable[str]], notes: tuple[str, ...] = ()
    ) -> None:
        """Offer the service, with the counts of *lost* messages, the present *problems*, and *notes* on the setup."""

        def answer(_request: HealthRequest) -> HealthResponse:
            troubles = sorted(problems())
            more = [f"{len(troubles) - _MAX_SHOWN} more do not pass"] if len(troubles) > _MAX_SHOWN else []
            refused = {event.removeprefix("ros2."): count for event, count in self._refused.items()}
            counts = (*Count.each(refused, Severity.FAULT), *Count.each({"lost": lost()}, Severity.LOSS))
            return HealthResponse(counts=counts, troubles=(*troubles[:_MAX_SHOWN], *more), notes=notes[:_MAX_SHOWN])

        self._node.create_service(GetHealth, "~/health", answer)
