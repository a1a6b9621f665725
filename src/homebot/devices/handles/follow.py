"""Live queries for handles: those that match now, and then every change."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import AsyncIterator, Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import timedelta
from functools import partial
from typing import TYPE_CHECKING, Final, Generic, Literal, NamedTuple, Self, TypeAlias, TypeVar, final, get_args

import anyio
from typing_extensions import ParamSpec

from homebot.clock import Clock
from homebot.devices.device import Device, DeviceChange, State, StateChange
from homebot.devices.device_view import DeviceView
from homebot.devices.follow import LiveQuery
from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import HandleQuery
from homebot.devices.house_view import HouseView
from homebot.devices.query.terms import And
from homebot.devices.value import PlainValue, Value
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.support.timer_queue import TimerQueue
from homebot.units import parse_duration

if TYPE_CHECKING:
    from homebot.devices.gateway_messages import RawMessage
    from homebot.devices.journal_messages import KnownCause

HandleT = TypeVar("HandleT", bound=Handle)
HandleT_co = TypeVar("HandleT_co", bound=Handle, covariant=True)
ConditionsP = ParamSpec("ConditionsP", default=...)

_Kind: TypeAlias = Literal["appeared", "changed", "event", "message", "removed"]

_MAX_EVENTS: Final = 1000
"""Events queued for a slow reader; the oldest is dropped and counted."""

_MAX_EARLY: Final = 100
"""Events queued until their device is described; the oldest is dropped."""

_EARLY: Final = 5.0
"""Seconds for which an event waits for the description of its device."""


@dataclass(frozen=True, slots=True)
class HandleChange(Generic[HandleT_co]):
    """A change of one part that a live query matches.

    Attributes:
        kind: ``appeared``: it matches the query from now on; ``changed``: its description or a value changed;
            ``event``: something without a duration happened, such as a button press; ``removed``: it is gone or no
            longer matches. Only :meth:`homebot.devices.Devices.messages` yields ``message``.
        handle: The handle of the part, the same object each time.
        event: The event, in ``event.capability`` and ``event.value``; None for the other kinds.
        message: The raw message; None for the other kinds.
        before: The values that changed since the last change of the handle, as they were then, by capability; None for
            one that was unknown. ``handle.value`` returns the present ones.
    """

    kind: _Kind
    handle: HandleT_co
    event: State | None = None
    message: RawMessage | None = None
    before: Mapping[str, PlainValue] = field(default_factory=dict, hash=False)

    @property
    def text(self) -> str:
        """The raw message, stripped and in lower case; empty if it is not text, and for the other kinds."""
        return "" if self.message is None else self.message.payload.decode(errors="ignore").strip().lower()

    async def cause(self, capability: str = "") -> KnownCause | None:
        """Return the cause of the newest change of a setting; None if the control layer has not seen it change.

        Args:
            capability: The setting; by default the first that changed.
        """
        capability = capability or next(iter(self.before), "")
        return await self.handle.cause(capability) if capability else None


class FollowHandles(LiveQuery[HandleChange[HandleT]], Generic[HandleT, ConditionsP]):
    """A live query for handles: ``async for change in devices.follow(Light, area="kitchen", on=True)``.

    Every handle that matches now is reported as ``appeared``, later ones when they appear. For each handle,
    ``appeared`` comes first and ``removed`` last. Changes of one handle while the reader is busy are reported as one,
    so that nothing piles up; every event is reported exactly once. If the directory is not running, the query waits for
    it. Only one task may read.

    Args:
        node: The node that asks; the query ends with it.

    Attributes:
        events_lost: Number of events dropped because 1,000 were waiting for the reader.
    """

    def __init__(self, node: Node, query: HandleQuery[HandleT], text: str = "the live query") -> None:
        super().__init__(node, And(query.names), text, query.near_search)
        self._query = query
        self._text = text
        self._reported: dict[str, dict[str, HandleChange[HandleT]]] = {}  # by device and part, prepared as "changed"
        self._before: dict[str, dict[tuple[str, str], Value]] = {}  # by device: what unread changes replaced
        self._compared: dict[str, Device] = {}  # the compared description, if new values cannot change the matches
        self._clock = node.graph.clock
        self._events: deque[StateChange] = deque()
        self._early_events: deque[tuple[float, StateChange]] = deque(maxlen=_MAX_EARLY)
        self.events_lost = 0

    def only(self, *kinds: _Kind) -> AsyncIterator[HandleChange[HandleT]]:
        """Return an iterator over the changes of these kinds: ``only("event")`` for button presses.

        Raises:
            UsageError: There is no such kind, or none is given.
        """
        known = get_args(_Kind)
        if not kinds or not set(kinds) <= set(known):
            raise UsageError(f"only() takes {', '.join(known)}; not {', '.join(map(repr, kinds)) or 'nothing'}")
        return self._only(kinds)

    async def _only(self, kinds: tuple[_Kind, ...]) -> AsyncIterator[HandleChange[HandleT]]:
        async for change in self:
            if change.kind in kinds:
                yield change

    def became(
        self,
        lasting: str | float | timedelta = 0.0,
        key: Callable[[HandleChange[HandleT]], Hashable] | None = None,
        *none: ConditionsP.args,
        **conditions: ConditionsP.kwargs,
    ) -> Became[HandleT]:
        """Return a live query that yields ``appeared`` each time a handle begins to meet further conditions.

        Handles that already meet them count too.

        Args:
            lasting: How long the conditions must be met first, such as ``"5m"``. Other changes do not interrupt the
                time; after a restart it begins anew, unless the device has reported these values for longer.
            key: Returns the key of a handle; all handles with the same key must meet the conditions, as all motion
                sensors of a room with :func:`homebot.apps.rooms.per_room`. Then the last one to do so is yielded.
            none: Not used: conditions are given by name.
            conditions: The conditions, as for :meth:`homebot.devices.Devices.find`, such as ``occupied=False``.

        Raises:
            TypeError: The kind has no such condition; the message suggests the nearest.
            UsageError: *lasting* is not a duration, or *key* is not a function.
        """
        if key is not None and not callable(key):
            raise UsageError(f"key: {key!r:.60} is not a function, such as per_room")
        more = self._query.kind.where(*none, **conditions)  # type: ignore[arg-type]  # checked there
        given = ", ".join(f"{name}={value!r}" for name, value in conditions.items())
        narrowed, text = self._query.narrowed(more), f"{self._text}.became({given})"
        follow = FollowHandles(self._node, narrowed if key is None else self._query, text)
        became = Became(follow, more.exact_values, parse_duration(lasting, "lasting"), self._clock)
        if key is not None:
            became.group(key, partial(_matches, HouseView.of(self._node), narrowed))
        return became

    def close(self) -> None:
        """End the query; idempotent."""
        self._events.clear()
        self._before.clear()
        super().close()

    def on_device(self, change: DeviceChange) -> None:
        """Store the newest change of a device for the reader, and the events that awaited its description."""
        super().on_device(change)
        if change.kind == "changed":
            self._record_replaced(change.device.id)
        if self._early_events:
            waiting, now = tuple(self._early_events), self._clock.monotonic()
            self._early_events.clear()
            for at, early in waiting:
                if early.device != change.device.id:
                    self._early_events.append((at, early))
                elif now - at <= _EARLY:
                    self._add_event(early)

    def on_values(self, change: StateChange) -> None:
        """Record that the values of a device changed."""
        super().on_values(change)
        self._record_replaced(change.device)
        self._changed[change.device] = change
        self._news.set()

    def on_event(self, change: StateChange) -> None:
        """Store an event; the event that reveals a device arrives on a different topic from its description."""
        if self._view is not None and self._view.get(change.device) is not None:
            self._add_event(change)
        else:
            self._early_events.append((self._clock.monotonic(), change))

    def _record_replaced(self, device_id: str) -> None:
        if self._view is not None and (known := self._view.get(device_id)) is not None:
            self._before[device_id] = known.replaced | self._before.get(device_id, {})

    def _add_event(self, change: StateChange) -> None:
        if len(self._events) >= _MAX_EVENTS:
            self._events.popleft()
            self.events_lost += 1
        self._events.append(change)
        self._news.set()

    def _next_change(self) -> DeviceChange | StateChange | None:
        return super()._next_change() or (self._events.popleft() if self._events else None)

    def _process(self, view: HouseView, change: DeviceChange | StateChange) -> None:
        if not isinstance(change, StateChange):
            self._compare(view, change.device.id)
        elif not change.is_event:
            self._compare(view, change.device)
        elif (known := self._reported.get(change.device, {}).get(change.readings[0].part)) is not None:
            self._ready.append(HandleChange("event", known.handle, change.states[0]))

    def _compare(self, view: HouseView, device_id: str) -> None:
        """Compare the handles of a device that were reported with those that match now."""
        known = view.get(device_id)
        reported, replaced = self._reported.pop(device_id, {}), self._before.pop(device_id, {})
        parts = [] if known is None else self._parts_now(known, reported)
        before: defaultdict[str, dict[str, PlainValue]] = defaultdict(dict)
        for (part, capability), value in replaced.items():
            before[part][capability] = value.plain()
        self._ready.extend(
            HandleChange("removed", change.handle, before=before[part])
            for part, change in reported.items()
            if part not in parts
        )
        if known is None:
            self._compared.pop(device_id, None)
            return
        matching: dict[str, HandleChange[HandleT]] = {}
        for part in parts:
            if part in reported:
                matching[part] = change = reported[part]
                self._ready.append(replace(change, before=before[part]) if part in before else change)
            else:
                handle = self._query.kind(known, part, view)
                matching[part] = HandleChange("changed", handle)
                self._ready.append(HandleChange("appeared", handle, before=before[part]))
        if matching:
            self._reported[device_id] = matching

    def _parts_now(self, known: DeviceView, reported: Iterable[str]) -> list[str]:
        """Return the parts that match now; the *reported* ones if nothing relevant to the query changed."""
        query, device_id = self._query, known.device.id
        is_same = self._compared.get(device_id) is known.device
        if is_same and query.near is None and not query.asks_for_values:
            return list(reported)
        self._compared[device_id] = known.device
        return query.parts(known.settled()) if self._is_near(device_id) else []


def _matches(view: HouseView, query: HandleQuery[HandleT], handle: HandleT) -> bool:
    known = view.get(handle.device.id)
    return known is not None and handle.part_id in query.parts(known.settled())


class _Match(NamedTuple):
    """Since when a handle matches.

    Attributes:
        since: The time that it reported, in seconds since the Unix epoch; 0 if unknown.
        begun: The time on the monotonic clock.
    """

    since: float
    begun: float


@final
class Became(Generic[HandleT]):
    """Iterator over the handles that have matched a live query for a while; see :meth:`FollowHandles.became`.

    The cause of a command in response to it is the change with which the handle began to match.

    Args:
        values: The capabilities that must have an exact value: if one had another value meanwhile, which a busy reader
            misses, the time begins anew.
        lasting: Seconds.
    """

    def __init__(self, follow: FollowHandles[HandleT], values: tuple[str, ...], lasting: float, clock: Clock) -> None:
        self._follow = follow
        self._values = values
        self._lasting = lasting
        self._clock = clock
        self._key: Callable[[HandleChange[HandleT]], Hashable] = lambda change: change.handle
        self._matches: Callable[[HandleT], bool] = lambda _: True
        self._keys: dict[HandleT, Hashable] = {}
        self._groups: dict[Hashable, dict[HandleT, _Match | None]] = {}  # None if it does not match
        self._begun: dict[Hashable, tuple[float, HandleT]] = {}  # since when a group matches, and its last handle
        self._due: TimerQueue[Hashable, tuple[HandleChange[HandleT], object]] = TimerQueue()

    def group(self, key: Callable[[HandleChange[HandleT]], Hashable], matches: Callable[[HandleT], bool]) -> None:
        """Count all handles with the same *key* as one, which matches if each of them does."""
        self._key, self._matches = key, matches

    @property
    def waiting(self) -> Iterator[tuple[str, float]]:
        """The names of matching handles, with the seconds until they have matched for long enough."""
        for key, (_, handle) in self._begun.items():
            if (due := self._due.time_of(key)) is not None:
                yield handle.name, due - self._clock.monotonic()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> HandleChange[HandleT]:
        """Return the next handle, as ``appeared``.

        Raises:
            StopAsyncIteration: The query or its node was closed.
        """
        while True:
            due = self._due.next()
            wait = math.inf if due is None else due - self._clock.monotonic()
            with anyio.CancelScope(deadline=anyio.current_time() + wait) as scope:
                self._record(await anext(self._follow))  # first, because a change reported meanwhile may end the wait
            if scope.cancelled_caught and (ended := self._due.pop(self._clock.monotonic())) is not None:
                _, (change, cause) = ended
                CURRENT_CAUSE.set(cause)
                return change

    def close(self) -> None:
        """End the query; idempotent."""
        self._follow.close()

    def _record(self, change: HandleChange[HandleT]) -> None:
        if change.kind == "event":
            return
        handle, key = change.handle, self._key(change)
        before = self._keys.pop(handle, key)  # its room may have changed
        match = self._groups.get(before, {}).pop(handle, None)
        if change.kind != "removed":
            self._keys[handle] = key
            match = self._match(handle, match) if self._matches(handle) else None
            self._groups.setdefault(key, {})[handle] = match
        for group_key in dict.fromkeys((before, key)):
            self._schedule(group_key, handle)

    def _schedule(self, key: Hashable, handle: HandleT) -> None:
        """Set when a group is due, after a change of *handle*."""
        group = self._groups.get(key, {})
        matches = [match.begun for match in group.values() if match is not None]
        if not group or len(matches) < len(group):
            self._begun.pop(key, None)
            self._due.discard(key)
            if not group:
                self._groups.pop(key, None)
            return
        known, begun = self._begun.get(key), max(matches)
        if known is None or begun > known[0] or (begun < known[0] and key in self._due):
            last = handle if handle in group else next(iter(group))
            self._begun[key] = begun, last
            self._due.set(key, begun + self._lasting, (HandleChange("appeared", last), CURRENT_CAUSE.get()))

    def _match(self, handle: HandleT, before: _Match | None) -> _Match:
        since = max(map(handle.since, self._values), default=0.0) if handle.freshness == "fresh" else 0.0
        if before is not None and since <= before.since:
            return before
        proven = self._clock.now() - since if since else 0.0
        return _Match(since, self._clock.monotonic() - max(0.0, proven))
