"""A live query for handles: those that match now, and then every change of them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final, Generic, Literal, TypeVar

from homebot.devices.device import Device, DeviceChange, State, StateChange
from homebot.devices.follow import LiveQuery
from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import HandleQuery
from homebot.devices.house_view import HouseView
from homebot.devices.query import And
from homebot.graph import Node

__all__ = ["FollowHandles", "HandleChange"]

HandleT = TypeVar("HandleT", bound=Handle)

_MAX_EVENTS: Final = 1000
"""Events that wait for a slow reader; the oldest is dropped and counted."""

_MAX_EARLY: Final = 100
"""Events that wait for the description of their device; the oldest is dropped."""

_EARLY: Final = 5.0
"""Seconds for which an event waits for the description of its device."""


@dataclass(frozen=True, slots=True)
class HandleChange(Generic[HandleT]):
    """A change of one part that a live query matches.

    Attributes:
        kind: ``appeared``: it matches the query from now on; ``changed``: its description or a value changed;
            ``event``: something happened that has no duration, such as a button press; ``removed``: it is gone or no
            longer matches.
        handle: The handle of the part, the same object each time.
        event: The event, in ``event.capability`` and ``event.value``; None for the other kinds.
    """

    kind: Literal["appeared", "changed", "event", "removed"]
    handle: HandleT
    event: State | None = None


class FollowHandles(LiveQuery[HandleChange[HandleT]], Generic[HandleT]):
    """A live query for handles: ``async for change in devices.follow(Light, area="kitchen", on=True)``.

    Every handle that matches now is reported as ``appeared``, later ones when they appear. Of each handle
    ``appeared`` comes first and ``removed`` last. Changes of one handle that happen while the reader is busy are
    reported as one, so that nothing piles up; every event is reported, once. If the directory is not running, the query
    waits for it. Only one task may read.

    Args:
        node: The node that asks; the query ends with it.
        query: The query.
        text: The call of the app that asks.

    Attributes:
        events_lost: Number of events dropped because 1,000 were waiting for the reader.
    """

    def __init__(self, node: Node, query: HandleQuery[HandleT], text: str = "the live query") -> None:
        super().__init__(node, And(query.names), text, query.near_search)
        self._query = query
        self._reported: dict[str, dict[str, HandleChange[HandleT]]] = {}  # by device and part, ready as "changed"
        self._compared: dict[str, Device] = {}  # by the description alone, if no new value changes the matches
        self._clock = node.graph.clock
        self._events: deque[StateChange] = deque()
        self._early_events: deque[tuple[float, StateChange]] = deque(maxlen=_MAX_EARLY)
        self.events_lost = 0

    def close(self) -> None:
        """End the query. Twice is fine."""
        self._events.clear()
        super().close()

    def on_device(self, change: DeviceChange) -> None:
        """Store the newest change of a device for the reader, and the events that waited for its description."""
        super().on_device(change)
        if self._early_events:
            self._add_early(change.device.id)

    def on_values(self, change: StateChange) -> None:
        """Store that the values of a device changed."""
        super().on_values(change)
        self._changed[change.device] = change
        self._news.set()

    def on_event(self, change: StateChange) -> None:
        """Store an event; the one that makes a device known comes on another topic than its description."""
        if self._view is not None and self._view.get(change.device) is not None:
            self._add_event(change)
        else:
            self._early_events.append((self._clock.monotonic(), change))

    def _add_event(self, change: StateChange) -> None:
        if len(self._events) >= _MAX_EVENTS:
            self._events.popleft()
            self.events_lost += 1
        self._events.append(change)
        self._news.set()

    def _add_early(self, device_id: str) -> None:
        waiting, now = tuple(self._early_events), self._clock.monotonic()
        self._early_events.clear()
        for at, change in waiting:
            if change.device != device_id:
                self._early_events.append((at, change))
            elif now - at <= _EARLY:
                self._add_event(change)

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
        """Compare the handles of a device that the reader has with those that match now."""
        known = view.get(device_id)
        reported = self._reported.pop(device_id, {})
        if known is None:
            self._compared.pop(device_id, None)
            self._ready.extend(HandleChange("removed", change.handle) for change in reported.values())
            return
        if (
            self._query.asks_for_values
            or self._query.near is not None
            or self._compared.get(device_id) is not known.device
        ):
            self._compared[device_id] = known.device
            parts = self._query.parts(known.current()) if self._is_near(device_id) else []
            self._ready.extend(
                HandleChange("removed", change.handle) for part, change in reported.items() if part not in parts
            )
        else:
            parts = list(reported)
        matching: dict[str, HandleChange[HandleT]] = {}
        for part in parts:
            if part in reported:
                matching[part] = reported[part]
                self._ready.append(reported[part])
            else:
                handle = self._query.kind(known, part, view)
                matching[part] = HandleChange("changed", handle)
                self._ready.append(HandleChange("appeared", handle))
        if matching:
            self._reported[device_id] = matching
