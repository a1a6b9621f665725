"""Events of quality of service: matched ends, missed deadlines, and liveliness. Loaded when used.

A status counts from the moment it is requested; its changes are those since the last call of its callback.

Sources: DDS 1.4, section 2.2.4.1 (communication status); ROS 2, rmw ``events_statuses``.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Sequence
from contextvars import Context
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, Self, TypeVar

from homebot.graph.qos import LivelinessPolicy, QoSProfile
from homebot.support.time_limits import TimeLimits

StatusT = TypeVar("StatusT", bound="QosStatus")


class TopicEnd(Protocol):
    """A publisher or a subscription."""

    qos: QoSProfile
    on_failure: Callable[[BaseException], None]

    def matched_ends(self) -> Sequence[TopicEnd]:
        """Return the other ends that it matches."""


class QosStatus:
    """Base of the statuses."""

    @classmethod
    def watch(cls, end: TopicEnd, callback: Callable[[Self], None]) -> EventWatcher[Self]:
        """Return a watcher of *end* that calls back with statuses of this kind."""
        watcher: EventWatcher[Self] = _WATCHERS[cls](end, cls, callback)
        for matched_end in end.matched_ends():
            watcher.on_match(matched_end, 1)
        return watcher


@dataclass(frozen=True, slots=True)
class MatchedStatus(QosStatus):
    """The number of matched ends of a topic: in total, and now."""

    total_count: int = 0
    total_count_change: int = 0
    current_count: int = 0
    current_count_change: int = 0


@dataclass(frozen=True, slots=True)
class _CountedStatus(QosStatus):
    total_count: int = 0
    total_count_change: int = 0


class OfferedDeadlineMissedStatus(_CountedStatus):
    """The number of deadlines that a publisher missed, counted from its first message."""


class RequestedDeadlineMissedStatus(_CountedStatus):
    """The number of deadlines without a message for a subscription, counted from its first message."""


class LivelinessLostStatus(_CountedStatus):
    """The number of leases in which a MANUAL_BY_TOPIC publisher did not assert its liveliness."""


@dataclass(frozen=True, slots=True)
class LivelinessChangedStatus(QosStatus):
    """The number of matched publishers that are alive, and of those whose lease ended.

    A MANUAL_BY_TOPIC publisher counts from its first assertion.
    """

    alive_count: int = 0
    not_alive_count: int = 0
    alive_count_change: int = 0
    not_alive_count_change: int = 0


class EventWatcher(Generic[StatusT]):
    """Counts the events of one end of a topic, and calls back with each new status.

    The callback runs in the next turn of the event loop, once for all events until then.
    """

    def __init__(self, end: TopicEnd, status: type[StatusT], callback: Callable[[StatusT], None]) -> None:
        """Use ``on_event`` of a publisher or a subscription instead."""
        self._end = end
        self._status = status
        self._callback = callback
        self._counts: Counter[str] = Counter()
        self._changes: Counter[str] = Counter()
        self._limits = TimeLimits()
        self._numbers: dict[object, int] = {}
        self._is_closed = False

    def on_match(self, end: TopicEnd, change: int) -> None:
        """Handle a match with *end* (1), or its end (-1)."""

    def on_activity(self, publisher: TopicEnd, *, is_message: bool) -> None:
        """Handle a message or another assertion of liveliness by *publisher*."""

    def close(self) -> None:
        """Stop calling back."""
        self._is_closed = True
        for key in tuple(self._numbers):
            self._stop_timer(key)

    def _restart_timer(self, key: object, seconds: float, on_idle: Callable[[], None]) -> None:
        """Call *on_idle* when *seconds* pass without a restart of the timer *key*."""
        self._stop_timer(key)
        self._numbers[key] = self._limits.set(seconds, on_idle)

    def _stop_timer(self, key: object) -> None:
        self._limits.discard(self._numbers.pop(key, 0))

    def _count(self, **changes: int) -> None:
        if not self._changes:
            asyncio.get_running_loop().call_soon(self._report, context=Context())
        for name, change in changes.items():
            self._counts[name] += change
            self._changes[f"{name}_change"] += change

    def _report(self) -> None:
        changes, self._changes = self._changes, Counter()
        if self._is_closed:
            return
        try:
            self._callback(self._status(**self._counts, **changes))
        except Exception as exc:  # noqa: BLE001 - recorded as the failure of its node
            self._end.on_failure(exc)


class _MatchWatcher(EventWatcher[StatusT]):
    def on_match(self, end: TopicEnd, change: int) -> None:  # noqa: ARG002 - all ends count the same
        self._count(total_count=max(change, 0), current_count=change)


class _DeadlineWatcher(EventWatcher[StatusT]):
    def on_activity(self, publisher: TopicEnd, *, is_message: bool) -> None:  # noqa: ARG002 - of any publisher
        if is_message and self._end.qos.deadline:
            self._restart_timer(self, self._end.qos.deadline, self._on_missed)

    def _on_missed(self) -> None:
        self._restart_timer(self, self._end.qos.deadline, self._on_missed)
        self._count(total_count=1)


class _LeaseWatcher(EventWatcher[StatusT]):
    """Counts the leases that a publisher missed."""

    def on_activity(self, publisher: TopicEnd, *, is_message: bool) -> None:  # noqa: ARG002 - either asserts
        lease = publisher.qos.liveliness_lease_duration
        if lease and publisher.qos.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC:
            self._restart_timer(publisher, lease, lambda: self._on_lost(publisher))

    def _on_lost(self, publisher: TopicEnd) -> None:
        self._stop_timer(publisher)
        self._count(total_count=1)


class _LivelinessWatcher(_LeaseWatcher[StatusT]):
    """Counts the live publishers among those that a subscription matches."""

    def __init__(self, end: TopicEnd, status: type[StatusT], callback: Callable[[StatusT], None]) -> None:
        super().__init__(end, status, callback)
        self._alive: dict[TopicEnd, bool] = {}

    def on_match(self, end: Any, change: int) -> None:
        if change < 0:
            self._stop_timer(end)
            was_alive = self._alive.pop(end, None)
            if was_alive is not None:
                self._count(**{"alive_count" if was_alive else "not_alive_count": -1})
        elif end.qos.liveliness is LivelinessPolicy.AUTOMATIC or end.is_lively():
            self.on_activity(end, is_message=False)

    def on_activity(self, publisher: TopicEnd, *, is_message: bool) -> None:
        was_alive = self._alive.get(publisher)
        self._alive[publisher] = True
        if not was_alive:
            self._count(alive_count=1, not_alive_count=-(was_alive is False))
        super().on_activity(publisher, is_message=is_message)

    def _on_lost(self, publisher: TopicEnd) -> None:
        self._stop_timer(publisher)
        self._alive[publisher] = False
        self._count(alive_count=-1, not_alive_count=1)


_WATCHERS: Final[dict[type[object], type[EventWatcher[Any]]]] = {
    MatchedStatus: _MatchWatcher,
    OfferedDeadlineMissedStatus: _DeadlineWatcher,
    RequestedDeadlineMissedStatus: _DeadlineWatcher,
    LivelinessLostStatus: _LeaseWatcher,
    LivelinessChangedStatus: _LivelinessWatcher,
}
