"""Collection of the values of all devices, for the next batch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, final

from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.devices.house_view import HouseWatcher
from homebot.features.history.batch import Batch, Place, Series, StateRow, StoredState
from homebot.features.history.buckets import COUNTERS
from homebot.features.history.counter import CounterTotal
from homebot.features.history.sealing import MASK

if TYPE_CHECKING:
    from homebot.clock import Clock
    from homebot.devices.device import DeviceChange, StateChange
    from homebot.devices.value import PlainValue

MAX_WAITING: Final = 100_000
"""The limit of values that wait for the disk; beyond it the oldest are lost and counted. 18 bytes each."""

_LOST_AT_ONCE: Final = 1000
_MAX_STATES: Final = 60
"""The limit of changes of a word or flag in one batch, after which only the newest counts, and of events, after which
none does: some texts change with each message."""

_MAX_WAITING_STATES: Final = 20_000
_MAX_WORD: Final = 100


@final
class _CollectedValue:
    """A series with its newest value."""

    __slots__ = ("changes", "opened_at", "series", "told_at", "total", "value")

    def __init__(self, series: Series, last: float | None) -> None:
        self.series = series
        self.total = CounterTotal(last) if series.place[2] in COUNTERS else None
        self.value: float | StoredState | None = None
        self.told_at = 0  # for a number
        self.opened_at = 0  # for a word or flag
        self.changes = 0


@final
class Collector(HouseWatcher):
    """Watches the house and collects the values of its devices.

    A number is collected when it changes, and with each batch while its device is alive, so a pause becomes a gap.

    Args:
        most: The largest number of series of the devices that there are.
        last: The last value of each counter in earlier runs, by the number of its series.

    Attributes:
        series: All series, by device, part and capability.
        batch: The values, states and new series to be written.
        lost: Values and states that were dropped because too many were waiting.
        left_out: Series for which there was no room.
        folded: Dropped changes of words and flags, of which only the newest was collected, and dropped events.
    """

    def __init__(self, clock: Clock, most: int, known: Mapping[Place, Series], last: Mapping[int, float]) -> None:
        self._clock = clock
        self._most = most
        self._last = dict(last)
        self._followed: dict[str, dict[tuple[str, str], _CollectedValue]] = {}
        self._count = 0
        self._units: dict[str, dict[tuple[str, str], str]] = {}
        self.series: dict[Place, Series] = dict(known)
        self._newest = max((series.number for series in known.values()), default=0)
        self.batch = Batch()
        self.lost = self.left_out = self.folded = 0

    @property
    def counters(self) -> frozenset[int]:
        """The numbers of the series of counters."""
        return frozenset(series.number for series in self.series.values() if series.place[2] in COUNTERS)

    @property
    def has_states(self) -> bool:
        """True if a word or flag is still in effect."""
        return any(collected.opened_at for followed in self._followed.values() for collected in followed.values())

    def on_device(self, change: DeviceChange) -> None:
        """Start or stop collecting the values of a device, depending on whether it is alive."""
        device = change.device
        if change.kind == "removed":
            self._forget(device.id)
            return
        self._units[device.id] = {
            (part.id, capability.name): capability.unit
            for part in device.parts
            for capability in part.part.capabilities
        }
        if device.freshness == "stale" or device.reachable.state == "no":
            now = self._now()
            for collected in self._followed.get(device.id, {}).values():
                self._end(collected, now)
        else:
            known, at = self._followed.get(device.id, {}), self._now()
            for state in device.states:
                followed = known.get((state.part, state.capability))
                if followed is None or followed.value is None:
                    value = state.value.plain()
                    if state.live or not isinstance(value, float):
                        self._record(device.id, state.part, state.capability, value, at)

    def on_values(self, change: StateChange) -> None:
        """Collect new values of a device."""
        at = change.told_at.sec * 1000 + change.told_at.nanosec // 1_000_000
        for reading in change.readings:
            self._record(change.device, reading.part, reading.capability, reading.value.plain(), at)

    def on_event(self, change: StateChange) -> None:
        """Collect an event, such as a press, as a word that ends at once."""
        self.on_values(change)

    def restart_total(self, series: int, last: float | None) -> None:
        """Let the counter of *series*, if it is one, go on from its *last* value after a correction."""
        self._keep_last(series, last)
        for followed in self._followed.values():
            for collected in followed.values():
                if collected.series.number == series and collected.total is not None:
                    collected.total = CounterTotal(last)

    def close(self) -> None:
        """End all values now. Idempotent."""
        self.interrupt(self._now())
        self._followed.clear()

    def interrupt(self, seen: int) -> None:
        """End all states at *seen*, in milliseconds since the Unix epoch, and restart all values now."""
        now = self._now()
        for followed in self._followed.values():
            for collected in followed.values():
                value = collected.value
                if isinstance(value, float):
                    self._add(collected, now, value)
                elif collected.opened_at and not isinstance(value, float | None):
                    self._close_state(collected, seen)
                    if seen != now:
                        self._open_state(collected, value, now)

    def repeat(self, at: int) -> None:
        """Collect each current number again at *at*, unless a newer one is known."""
        for followed in self._followed.values():
            for collected in followed.values():
                if isinstance(collected.value, float) and collected.told_at < at:
                    self._add(collected, at, collected.value)
                collected.changes = 0

    def renew(self) -> None:
        """Write all series and current states again, because the file is new."""
        self.batch.new = list(self.series.values())
        for followed in self._followed.values():
            for collected in followed.values():
                if collected.opened_at and not isinstance(collected.value, float | None):
                    self.batch.states[collected.opened_at, collected.series.number] = StateRow(None, collected.value)

    def _forget(self, device: str) -> None:
        """Let a device that was removed make room for others."""
        self._units.pop(device, None)
        gone, now = self._followed.pop(device, {}), self._now()
        self._count -= len(gone)
        for collected in gone.values():
            self._end(collected, now)
            if collected.total is not None:
                self._keep_last(collected.series.number, collected.total.last)

    def _keep_last(self, series: int, last: float | None) -> None:
        if last is None:
            self._last.pop(series, None)
        else:
            self._last[series] = last

    def _end(self, followed: _CollectedValue, at: int) -> None:
        if followed.opened_at:
            self._close_state(followed, at)
        followed.value = None

    def _record(self, device: str, part: str, capability: str, value: PlainValue, at: int) -> None:
        followed = self._followed.get(device, {}).get((part, capability))
        if followed is None and (value is None or (followed := self._follow((device, part, capability))) is None):
            return
        match value:
            case str() if capability in EVENTS:
                self._record_event(followed, value[:_MAX_WORD], at)
            case bool() | str():
                word = int(value) if isinstance(value, bool) else value[:_MAX_WORD]
                self._record_state(followed, word, at)
            case float():
                self._record_number(followed, value, at)
            case _:
                self._end(followed, at)

    def _record_number(self, followed: _CollectedValue, value: float, at: int) -> None:
        if value == followed.value and at <= followed.told_at:
            return  # the report of a value with which its device appeared
        if followed.opened_at:
            self._close_state(followed, at)
        is_gap = followed.value is None or at < followed.told_at  # the clock may have been set back
        recorded: tuple[float, ...] = (value,)
        if (total := followed.total) is not None:
            if is_gap and total.last is not None:
                self._add(followed, at, total.last)  # it may have risen in the gap
            recorded = total.record(value, at)
            value = value if total.last is None else total.last
        followed.value = value
        for recorded_value in recorded:
            self._add(followed, at, recorded_value)

    def _record_state(self, followed: _CollectedValue, value: StoredState, at: int) -> None:
        if followed.opened_at:
            if followed.value == value:
                return
            followed.changes += 1
            if followed.changes > _MAX_STATES:
                self.folded += 1
                followed.value = value
                self.batch.states[followed.opened_at, followed.series.number] = StateRow(None, value)
                return
            self._close_state(followed, at)
        self._open_state(followed, value, at)

    def _record_event(self, followed: _CollectedValue, word: str, at: int) -> None:
        followed.changes += 1
        if followed.changes > _MAX_STATES:
            self.folded += 1
            return
        self._open_state(followed, word, at)
        self._close_state(followed, followed.opened_at)

    def _open_state(self, followed: _CollectedValue, value: StoredState, at: int) -> None:
        states, number = self.batch.states, followed.series.number
        while (at, number) in states:
            at += 1
        if len(states) >= _MAX_WAITING_STATES:
            del states[next(iter(states))]
            self.lost += 1
        states[at, number] = StateRow(None, value)
        followed.opened_at, followed.value = at, value

    def _close_state(self, followed: _CollectedValue, at: int) -> None:
        value, key = followed.value, (followed.opened_at, followed.series.number)
        if value is not None:
            self.batch.states[key] = StateRow(
                max(at, followed.opened_at), value if isinstance(value, str) else int(value)
            )
        followed.opened_at = 0

    def _add(self, followed: _CollectedValue, at: int, value: float) -> None:
        followed.told_at = at
        self.batch.add(followed.series.number, at, value)
        if len(self.batch.times) > MAX_WAITING:
            self.batch.drop_oldest(_LOST_AT_ONCE)
            self.lost += _LOST_AT_ONCE

    def _follow(self, place: Place) -> _CollectedValue | None:
        """Return the series of *place*, a new one if there is room for it."""
        series = self.series.get(place)
        if series is None:
            if self._count >= self._most or self._newest >= MASK:
                self.left_out += 1
                return None
            self._newest += 1
            device, part, capability = place
            unit = self._units.get(device, {}).get((part, capability)) or CAPABILITIES.get(capability, OWN).unit
            series = self.series[place] = Series(self._newest, place, unit)
            self.batch.new.append(series)
        self._count += 1
        followed = _CollectedValue(series, self._last.get(series.number))
        self._followed.setdefault(place[0], {})[place[1], place[2]] = followed
        return followed

    def _now(self) -> int:
        return round(self._clock.now() * 1000)
