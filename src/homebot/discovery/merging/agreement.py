"""Agreement of endpoints: one that reports the same changes as a trusted one is the same device. Pure.

An impostor does not know when the device changes. One equal change may be a coincidence, and an endpoint
that changes all the time is right now and then. So three changes have to be reported by both, each some time after the
one before, and every change that only one of them reports begins the count anew. Numbers do not count, because two
conventions round them differently. Nothing of this counts for a device of a type that can hurt: its state may be seen
from the street.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TypeAlias, final

from homebot.devices.value import PlainValue
from homebot.discovery.merging.trust import EndpointKey

__all__ = ["CHANGES_NEEDED", "WINDOW", "Agreement", "Change"]

CHANGES_NEEDED = 3
"""Changes that both have to report."""

WINDOW = 15.0
"""Seconds within which both have to report one, as some endpoints are asked only every ten seconds; and those between
two that count."""

_MOST = 32
"""Changes that wait for another endpoint; the oldest is then taken for missed."""

Change: TypeAlias = tuple[int, str, PlainValue]
"""The number of a part, a capability of it, and its new value."""


@dataclass(slots=True)
class _Reported:
    """A change, and the endpoint that reported it."""

    at: float
    claimed: frozenset[EndpointKey]
    by_trusted: bool = False
    by_claimed: set[EndpointKey] = field(default_factory=set)

    @property
    def missed(self) -> frozenset[EndpointKey]:
        """The claimed endpoints that did not report it, or reported it alone."""
        return self.claimed - self.by_claimed if self.by_trusted else frozenset(self.by_claimed)


@final
class Agreement:
    """The changes that the endpoints of one device reported lately, and how often claimed ones were right."""

    __slots__ = ("_counts", "_lately")

    def __init__(self) -> None:
        self._counts: dict[EndpointKey, tuple[int, float]] = {}
        self._lately: OrderedDict[Change, _Reported] = OrderedDict()

    def record(
        self, change: Change, endpoint: EndpointKey, claimed: Iterable[EndpointKey], now: float
    ) -> frozenset[EndpointKey]:
        """Note that *endpoint* reported a change.

        Args:
            now: Seconds of a clock that is never set.

        Returns:
            Those of them that are to be trusted from now on.
        """
        while self._lately and now - next(iter(self._lately.values())).at > WINDOW:
            self._close(self._lately.popitem(last=False)[1])
        waiting = frozenset(claimed)
        is_claimed = endpoint in waiting
        known = self._lately.get(change)
        if known is not None and (endpoint in known.by_claimed if is_claimed else known.by_trusted):
            self._close(self._lately.pop(change))  # it changed back and forth meanwhile
            known = None
        known = known or self._begin(change, now, waiting)
        if is_claimed:
            known.by_claimed.add(endpoint)
            agreeing = frozenset({endpoint} if known.by_trusted else ())
        else:
            known.by_trusted = True
            agreeing = waiting & known.by_claimed
        for one in agreeing:
            count, last = self._counts.get(one, (0, -WINDOW + known.at))
            if now - last >= WINDOW:
                self._counts[one] = count + 1, now
        return frozenset([one for one in agreeing if self._counts[one][0] >= CHANGES_NEEDED])

    def _begin(self, change: Change, now: float, waiting: frozenset[EndpointKey]) -> _Reported:
        reported = self._lately[change] = _Reported(now, waiting)
        if len(self._lately) > _MOST:
            self._close(self._lately.popitem(last=False)[1])
        return reported

    def _close(self, reported: _Reported) -> None:
        for one in reported.missed:
            self._counts.pop(one, None)
