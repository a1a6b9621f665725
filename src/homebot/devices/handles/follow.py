"""A live query for handles: those that match now, and then every change of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Literal, Self, TypeVar

import anyio
import anyio.lowlevel

from homebot.devices.device import Device, DeviceChange, State, StateChange
from homebot.devices.follow import Follow
from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import HandleQuery
from homebot.devices.handles.handles import Handles
from homebot.devices.handles.tracked_device import TrackedDevice
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE

__all__ = ["FollowHandles", "HandleChange"]

HandleT = TypeVar("HandleT", bound=Handle)

_TURN = 100
"""Changes given out before other tasks get their turn, should the reader never wait."""

_MAX_EVENTS = 1000
"""Events that wait for a slow reader; the oldest is dropped and counted."""

_MAX_EARLY = 100
_MOMENT = 5.0
"""Seconds for which an event waits for its device to be described."""


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


class FollowHandles(Generic[HandleT]):
    """A live query for handles: ``async for change in devices.follow(Light, area="kitchen", on=True)``.

    Every handle that matches now is reported as ``appeared``, later ones when they appear. Of each handle
    ``appeared`` comes first and ``removed`` last. Changes of one handle that happen while the reader is busy are
    reported as one, so that nothing piles up; every event is reported, once. If the directory is not running, the query
    waits for it. Only one task may read.

    Args:
        node: The node that asks; the query ends with it.
        handles: The source of the handles.
        query: The query.

    Attributes:
        events_lost: Number of events dropped because 1,000 were waiting for the reader.
    """

    def __init__(self, node: Node, handles: Handles, query: HandleQuery[HandleT]) -> None:
        self._node = node
        self._handles = handles
        self._query = query
        self._devices: Follow | None = None
        self._tracked: dict[str, TrackedDevice] = {}
        self._reported: dict[str, dict[str, HandleChange[HandleT]]] = {}  # ready to be given out as "changed"
        self._compared: dict[str, Device] = {}  # by the description alone: no new value changes the matches
        self._changed: dict[str, StateChange | DeviceChange] = {}  # the newest change of each
        self._cause: StateChange | DeviceChange | None = None  # of the ready devices
        self._ready: deque[HandleChange[HandleT]] = deque()
        self.events_lost = 0
        self._clock = node.graph.clock
        self._events: deque[StateChange] = deque()
        self._early_events: deque[tuple[float, StateChange]] = deque(maxlen=_MAX_EARLY)
        self._has_news = anyio.Event()
        self._unwatch: Callable[[], None] | None = None
        self._is_closed = False
        self._count = 0

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> HandleChange[HandleT]:
        """Return the next change.

        Raises:
            StopAsyncIteration: The query or its node was closed.
        """
        if self._devices is None and not self._is_closed:
            self._devices = devices = Follow(self._node)
            self._unwatch = self._handles.watch(self._mark_changed, self._on_event)
            self._node.create_task(lambda: self._follow(devices))
        self._count += 1
        if self._count % _TURN == 0:
            await anyio.lowlevel.checkpoint()
        while not self._ready:
            if self._changed:
                device_id = next(iter(self._changed))
                self._cause = self._changed.pop(device_id)
                self._compare(device_id)
            elif self._events:
                self._cause = event = self._events.popleft()
                self._report_event(event)
            elif self._is_closed:
                raise StopAsyncIteration
            else:
                await self._has_news.wait()
                self._has_news = anyio.Event()
        CURRENT_CAUSE.set(self._cause)
        return self._ready.popleft()

    def close(self) -> None:
        """End the query. Twice is fine."""
        if not self._is_closed:
            self._is_closed = True
            self._changed.clear()
            self._events.clear()
            self._ready.clear()
            self._has_news.set()
            if self._devices is not None:
                self._devices.close()
            if self._unwatch is not None:
                self._unwatch()

    async def _follow(self, devices: Follow) -> None:
        try:
            async for change in devices:
                device = change.device
                self._tracked[device.id] = self._handles.track(
                    device, change.sequence, is_gone=change.kind == "removed"
                )
                self._mark_changed(device.id, change)
                self._add_early(device.id)
        finally:
            self.close()

    def _on_event(self, device_id: str, change: StateChange) -> None:
        if device_id in self._tracked:
            self._add_event(change)
        else:  # the event that made the device known comes on another topic than its description
            self._early_events.append((self._clock.monotonic(), change))

    def _add_event(self, change: StateChange) -> None:
        if len(self._events) >= _MAX_EVENTS:
            self._events.popleft()
            self.events_lost += 1
        self._events.append(change)
        self._has_news.set()

    def _add_early(self, device_id: str) -> None:
        """Report the events of a device that was not known a moment ago."""
        early, now = self._early_events, self._clock.monotonic()
        self._early_events = deque((one for one in early if one[1].device != device_id), maxlen=early.maxlen)
        for at, change in early:
            if change.device == device_id and now - at <= _MOMENT:
                self._add_event(change)

    def _report_event(self, change: StateChange) -> None:
        reported = self._reported.get(change.device, {})
        (event,) = change.states
        if (known := reported.get(event.part)) is not None:
            self._ready.append(HandleChange("event", known.handle, event))

    def _mark_changed(self, device_id: str, change: StateChange | DeviceChange) -> None:
        if device_id in self._tracked:
            if not self._changed:  # while others wait, the reader is awake
                self._has_news.set()
            self._changed[device_id] = change

    def _compare(self, device_id: str) -> None:
        """Compare the handles of a device that the reader has with those that match now."""
        known = self._tracked[device_id]
        reported = self._reported.get(device_id, {})
        if self._compared.get(device_id) is known.device and not known.is_gone:
            self._ready.extend(reported.values())
            return
        parts = [] if known.is_gone else self._query.parts(known.current())
        for part in [part for part in reported if part not in parts]:
            self._ready.append(HandleChange("removed", reported.pop(part).handle))
        for part in parts:
            if part in reported:
                self._ready.append(reported[part])
            else:
                (handle,) = self._handles.of_parts(self._query.kind, known, [part])
                reported[part] = HandleChange("changed", handle)
                self._ready.append(HandleChange("appeared", handle))
        if known.is_gone:
            del self._tracked[device_id]
            self._compared.pop(device_id, None)
        elif not self._query.asks_for_values:
            self._compared[device_id] = known.device
        if reported:
            self._reported[device_id] = reported
        else:
            self._reported.pop(device_id, None)
