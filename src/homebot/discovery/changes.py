"""Changes of devices: those waiting to be published, and the last ones for late clients. Pure."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import takewhile
from typing import TypeAlias, final

from homebot.devices import Device, DeviceChange, StateChange
from homebot.devices.capabilities import EVENTS
from homebot.devices.device import ChangeKind
from homebot.devices.part import size_of_texts, texts_of
from homebot.devices.value import Reading
from homebot.discovery.entry import Entry
from homebot.discovery.merging.parts import MergedParts
from homebot.discovery.topics.ownership import TopicOwnership
from homebot.messages import Time

_MAX_STATES = 10_000

_EVENTS = 100
"""Most unread events of a reader."""

REMEMBERED = 2000
"""Most changes kept for late clients."""

MAX_SIZE = 16 * 1024 * 1024
"""Estimated bytes of all kept changes: each contains the whole device."""

_CHANGE = 4096
"""Estimated bytes of a change without its texts and parts."""

_PART = 1024
"""Estimated bytes of a part without its lists."""


NewStates: TypeAlias = tuple[Entry, MergedParts, tuple[Reading, ...], str, Time, bool]
"""The new values of a report, or one event: the device, its parts at the time, the values, the stream of their change,
the time of the report, and whether it came live from the device."""


# Looked up once, as `of_checked` says.
_change_of, _device_change_of = StateChange.of_checked, DeviceChange.of_checked

stream_of = "\0".join
"""Returns the stream of a change: the id of the device, with part and capability of each value."""


@dataclass(slots=True, eq=False)
class _PendingChange:
    kind: ChangeKind
    entry: Entry
    why: str
    other: str
    device: Device | None = None
    is_of_link: bool = False


@final
class ChangeQueue:
    """Collects changes, so that a device that is announced in thirty messages is published once.

    Attributes:
        sequence: Number of the last change that was popped.
        states_lost: Changes of states that were dropped before they were popped.
        of_links: Numbers of the changes popped last that were due to a gateway's link, lost or restored.
        growing: Changes of devices with further announcements, by id, until :meth:`end_growth`.
        recent: The last popped changes, for late clients.
        announced: The number of new or changed announcements so far, and of first reachabilities.
    """

    def __init__(self, entries: Mapping[str, Entry], topics: TopicOwnership, first_sequence: int) -> None:
        self.sequence = first_sequence - 1
        self.states_lost = 0
        self._events = 0
        self._entries = entries
        self._topics = topics
        self.pending: list[_PendingChange] = []
        self._last: dict[str, _PendingChange] = {}
        self.states: list[NewStates] = []
        self.of_links: set[int] = set()
        self.growing: dict[str, _PendingChange] = {}
        self.recent = ChangeLog(self.sequence)
        self.announced = 0
        self.collects_states = False
        self.collects_settings = False

    def add(self, kind: ChangeKind, entry: Entry, why: str, other: str = "", *, is_of_link: bool = False) -> None:
        """Add a change of *entry*; a mere ``changed`` is merged into a waiting change."""
        pending = self._last.get(entry.id)
        if kind == "changed" and pending is not None and pending.kind != "stale":
            return
        self.growing.pop(entry.id, None)
        change = _PendingChange(kind, entry, why, other, is_of_link=is_of_link)
        self.pending.append(change)
        self._last[entry.id] = change

    def add_growth(self, entry: Entry, why: str) -> None:
        """Add a further announcement of *entry*, as part of its next change or that at the end of growth."""
        if entry.id not in self._last:
            self.growing[entry.id] = _PendingChange("changed", entry, why, "")

    def end_growth(self) -> None:
        """Release the changes of devices with further announcements."""
        self._last.update(self.growing)
        self.pending += self.growing.values()
        self.growing.clear()

    def add_removal(self, entry: Entry, why: str, other: str = "") -> None:
        """Add the removal of *entry*, which is published as it is now."""
        device = entry.to_device(self._topics)
        self.growing.pop(entry.id, None)
        if self._last.pop(entry.id, None) is not None:
            for change in self.pending:
                if change.entry is entry and change.device is None:
                    change.device = device
        self.pending.append(_PendingChange("removed", entry, why, other, device))

    def event_number(self) -> str:
        """Return the key for coalescing: one per state, none for events."""
        self._events = (self._events + 1) % _EVENTS
        return str(self._events)

    def add_states(self, states: NewStates) -> None:
        """Add new values, or one event; they are dropped and counted while 10,000 wait."""
        if len(self.states) >= _MAX_STATES:
            self.states_lost += 1
        else:
            self.states.append(states)

    def pop(self, at_most: int | None = None) -> tuple[DeviceChange, ...]:
        """Remove and return the oldest changes, with the disputes they caused."""
        if at_most is None:
            self.end_growth()
        taken = self.pending[:at_most]
        del self.pending[: len(taken)]
        changes: list[DeviceChange] = []
        self.of_links.clear()
        for pending_change in taken:
            changes += self._changes(pending_change)
        for change in changes:
            self.recent.append(change)
        return tuple(changes)

    def pop_states(self, at_most: int | None = None) -> tuple[StateChange, ...]:
        """Remove and return the changes of states, oldest first, without those of removed parts."""
        taken = self.states[:at_most]
        del self.states[: len(taken)]
        changes: list[StateChange] = []
        for entry, parts, readings, whole, told_at, live in taken:
            current, stream = readings, whole
            if self._entries.get(entry.id) is not entry or entry.parts(self._topics) is not parts:
                current = self._current(entry, readings)
                if not current:
                    continue
                if len(current) < len(readings):
                    names = [name for change in current for name in (change.part, change.capability)]
                    stream = stream_of((entry.id, *names))
            self.sequence += 1
            changes.append(
                _change_of(
                    stream=stream,
                    device=entry.id,
                    readings=current,
                    told_at=told_at,
                    live=live,
                    sequence=self.sequence,
                )
            )
        return tuple(changes)

    def _current(self, entry: Entry, readings: tuple[Reading, ...]) -> tuple[Reading, ...]:
        """Return the *readings* whose part and capability still exist."""
        if self._entries.get(entry.id) is not entry:
            return ()
        if readings[0].capability in EVENTS:
            ids = {part.id for part in entry.parts(self._topics).parts}
            return tuple([reading for reading in readings if reading.part in ids])
        places = {(known.part, known.capability) for known in entry.to_device(self._topics).states}
        return tuple([reading for reading in readings if (reading.part, reading.capability) in places])

    def _changes(self, change: _PendingChange) -> list[DeviceChange]:
        """Return the change, and the disputes that it caused."""
        entry = change.entry
        if self._last.get(entry.id) is change:
            del self._last[entry.id]
        device = change.device or entry.to_device(self._topics)
        changes = [self._change(change.kind, device, change.why, change.other)]
        if change.is_of_link:
            self.of_links.add(self.sequence)
        before, entry.published_conflicts = entry.published_conflicts, device.conflicts
        if before == device.conflicts or change.kind == "removed":
            return changes
        if not device.conflicts:
            changes.append(self._change("resolved", device, "none of its command topics is disputed any more"))
        elif new := [conflict for conflict in device.conflicts if conflict not in before]:
            changes.append(self._change("conflict", device, "; ".join(new)))
        return changes

    def _change(self, kind: ChangeKind, device: Device, why: str, other: str = "") -> DeviceChange:
        self.sequence += 1
        return _device_change_of(kind=kind, device=device, sequence=self.sequence, why=why, other=other)


class ChangeLog:
    """The last changes in order; the oldest are forgotten when there are too many bytes or changes.

    Args:
        first: Sequence number from which on it is complete.

    Attributes:
        forgotten: Sequence number of the newest forgotten change.
    """

    def __init__(self, first: int, most: int = REMEMBERED, max_size: int = MAX_SIZE) -> None:
        self.forgotten = first
        self._most = most
        self._max_size = max_size
        self._size = 0
        self._changes: deque[tuple[DeviceChange, int]] = deque()

    def append(self, change: DeviceChange) -> None:
        """Add *change*, and forget the oldest ones beyond the limits."""
        device = change.device
        texts = [device.name, device.area, change.why, *device.identifiers, *device.evidence, *device.conflicts]
        for fact in device.metadata:
            texts += (fact.key, fact.value)
        for part in device.parts:
            texts += texts_of(part.part)
        size = _CHANGE + size_of_texts(texts) + _PART * len(device.parts)
        self._changes.append((change, size))
        self._size += size
        while len(self._changes) > self._most or self._size > self._max_size:
            oldest, its_size = self._changes.popleft()
            self._size -= its_size
            self.forgotten = oldest.sequence

    def since(self, sequence: int) -> tuple[DeviceChange, ...]:
        """Return the known changes after number *sequence*."""
        newer = takewhile(lambda change: change.sequence > sequence, (change for change, _ in reversed(self._changes)))
        return tuple(newer)[::-1]

    def __len__(self) -> int:
        return len(self._changes)
