"""The recorder of reported states: stores them by announcement, updates postings, publishes. Pure."""

from __future__ import annotations

from collections.abc import Callable, Container, Generator, Iterable, Iterator
from math import inf
from operator import attrgetter
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias, final

from homebot.devices import Fact
from homebot.devices.capabilities import ALERTING, EVENTS, SETTABLE
from homebot.devices.device import ChangedSetting
from homebot.devices.echoes import Echoes
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.names import UNREADABLE
from homebot.devices.value import Reading, SetBy, Value
from homebot.discovery.changes import stream_of
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.liveness import Liveness
from homebot.discovery.merging.parts import MergedParts
from homebot.discovery.merging.trust import Agreement, EndpointKey, can_hurt, endpoint_of, takes_commands
from homebot.discovery.search.columns import StoredValue
from homebot.discovery.source_record import LostLink, Reach, SourceRecord
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.discovery.reading_limits import LimitsOfDevices

_NAME = attrgetter("name")
_CAPABILITY = attrgetter("capability")

_NewValue: TypeAlias = tuple[tuple[str, str], Reading, StoredValue]
"""A part and its capability, the new value, and its storage."""

_MAX_CHANGED: Final = 10_000
"""Most changed settings waiting to be popped; further ones are dropped and counted as lost states."""

_REPORTED: Final = SETTABLE | ALERTING


class _WaitingChange(NamedTuple):
    """The first change of a setting since the last time, and the stored value, which is the newest."""

    entry: Entry
    source: SourceRecord
    new: Reading
    since: Time
    was_absent: bool
    set_by: SetBy
    before: Value
    before_since: Time
    stored: StoredValue


Trust: TypeAlias = Callable[[Entry, frozenset[EndpointKey]], None]


@final
class StateRecorder:
    """Records the reports of known devices.

    Args:
        trust: Lets endpoints get the commands of a device, because they reported the same changes as the others.
    """

    def __init__(self, table: DeviceTable, liveness: Liveness, trust: Trust, settings: SettingChanges) -> None:
        self._table = table
        self._liveness = liveness
        self._trust = trust
        self._settings = settings

    def record(self, entry: Entry, source: SourceRecord, report: Report) -> None:
        """Record *report*, received through *source*, an announcement of *entry*."""
        states_reach = REACHABLE in map(_CAPABILITY, report.readings)
        for unreadable in report.unreadable:
            self._record_unreadable(entry, source, unreadable.key, unreadable.value, report.received_at)
        if self._table.limits is not None:
            report = self._within_limits(entry, source, report, self._table.limits)
        before = self._reach(entry) if states_reach or entry.is_denied else None
        if new := self._record_values(entry, source, report):
            self._publish(entry, source, new, report)
        if report.retained or report.address == "" or (states_reach and _denies_life(report)):
            entry.device = None
        else:
            self._liveness.mark_seen(entry, source, report.received_at, "it sent a message")
        if before is not None and self._reach(entry) != before:
            self._table.record_change("changed", entry, entry.reachability().why)

    def _record_unreadable(self, entry: Entry, source: SourceRecord, part: str, why: str, at: Time) -> None:
        if not source.unreadable:
            self._table.outdated[entry.id] = None
        (gateway, key), convention = source.key, source.sighting.convention
        source.unreadable = {
            **source.unreadable,
            part: Fact(name=UNREADABLE, value=why, gateway=gateway, convention=convention, key=key, said_at=at),
        }
        entry.device = None

    def _within_limits(self, entry: Entry, source: SourceRecord, report: Report, given: LimitsOfDevices) -> Report:
        """Return *report* without the values outside the limits *given*, which are recorded as unreadable."""
        if given.capabilities.isdisjoint(map(_CAPABILITY, report.readings)):
            return report
        device = entry.to_device(self._table.topics)
        if (limits := given.of((device.id, *device.names))) is None:
            return report
        kept: list[Reading] = []
        for reading in report.readings:
            if problem := limits.problem(reading):
                self._table.counters.outside_limits += 1
                self._record_unreadable(entry, source, reading.part, problem, report.received_at)
            else:
                kept.append(reading)
        return report.model_copy(update={"readings": tuple(kept)})

    def record_link(self, gateway: str, lost: LostLink | None) -> Generator[None, None, int]:
        """Record that *gateway* lost or restored its link; return the number of devices for which that matters.

        It pauses after each device.
        """
        table = self._table
        before, count = table.lost.pop(gateway, None), 0
        if lost is not None:
            lost = table.lost[gateway] = lost if before is None else LostLink(before.since, lost.why)
        for key in [key for key in table.sources if key[0] == gateway]:
            if (source := table.sources.get(key)) is not None:
                count += self._record_link_of(table.owners[key], source, lost)
            yield
        return count

    def _record_link_of(self, entry: Entry, source: SourceRecord, lost: LostLink | None) -> bool:
        """Record the link of *source*; return whether that changed the reachability of *entry*."""
        before = self._reach(entry)
        source.lost, source.absences = lost, {**source.absences, "": self._liveness.now}
        entry.is_denied = is_denied(entry.sources.values())
        entry.device = None
        after = self._reach(entry)
        if after != before:
            why = f"{source.key[0]} has its link again" if lost is None else lost.why
            self._table.record_change("changed", entry, why, is_of_link=True)
        return (before[0] == "no") is not (after[0] == "no")

    def _record_values(self, entry: Entry, source: SourceRecord, report: Report) -> list[_NewValue]:
        """Record the readings of *report*; return the new values among them."""
        live, now, stamp = not report.retained, self._liveness.now, report.received_at
        new: list[_NewValue] = []
        values = source.values
        for reading in report.readings:
            place = reading.part, reading.capability
            stored = values.get(place)
            if stored is None:
                stored = self._record_first(entry, source, reading, report)
                if stored is not None:
                    new.append((place, reading, stored))
            elif live or not stored.live:  # retained values never overwrite live ones
                heard_at = stored.heard_at
                stored.told_at, stored.heard_at = stamp, now
                if reading.value is not stored.reported and self._replace(entry, source, reading, stored, report):
                    absences = source.absences
                    stored.was_absent = heard_at <= max(absences.get("", -inf), absences.get(reading.part, -inf))
                    new.append((place, reading, stored))
                stored.live = live
        return new

    def _replace(
        self, entry: Entry, source: SourceRecord, reading: Reading, stored: StoredValue, report: Report
    ) -> bool:
        """Store the value of *reading*; return whether it has changed."""
        value, live = reading.value, not report.retained
        plain, known = value.plain(), stored.value
        if known == plain and type(known) is type(plain):
            return False
        if entry.claimed and live:
            self._compare(entry, source, reading)
        if stored.live and known is not None:
            stored.before, stored.before_since = stored.reported, stored.since
        stored.reported, stored.value, stored.since = value, plain, report.received_at
        stored.is_first = stored.is_first and (not live or known is None)
        if stored.column is not None:
            stored.column.values[stored.row] = plain
        return True

    def _record_first(self, entry: Entry, source: SourceRecord, reading: Reading, report: Report) -> StoredValue | None:
        """Record a reachability, an event, or the first value of a capability, which it returns."""
        stamp, live = report.received_at, not report.retained
        if reading.capability == REACHABLE:
            if not reading.value.flag:
                source.absences = {**source.absences, reading.part: self._liveness.now}
            if report.address:
                if reading.part not in source.reach:
                    self._table.changes.announced += 1  # the first one still belongs to its announcement
                store_reachability(entry, source, reading, report, self._liveness.now)
            else:  # the device reports it no longer
                source.set_reach({part: reach for part, reach in source.reach.items() if part != reading.part})
            return None
        if reading.capability in EVENTS:
            if live:
                self._record_event(entry, source, reading, stamp)
            return None
        if not has_capability(source, reading.part, reading.capability):
            self._table.counters.unknown_parts += 1
            return None
        place = reading.part, reading.capability
        _, *others = entry.sources
        if others and not source.values:  # it may get commands from now on
            entry.device, self._table.outdated[entry.id] = None, None
        stored = StoredValue(reading.value, reading.value.plain(), stamp, stamp, live, self._liveness.now)
        is_first, source.values[place] = not source.values, stored
        if others and is_first:
            self._table.judge_topics(entry)
        self._post(entry, source, place, stored)
        return stored

    def _compare(self, entry: Entry, source: SourceRecord, reading: Reading) -> None:
        """Record a change of a device with claimed endpoints; those that report the same changes become trusted."""
        value = reading.value.plain()
        number = entry.parts(self._table.topics).places.get((*source.key, reading.part))
        if number is None or not isinstance(value, bool | str) or not takes_commands(source.sighting):
            return
        if can_hurt(known_source.sighting for known_source in entry.sources.values()):
            return
        entry.agreement = entry.agreement or Agreement()  # few devices have claimed endpoints
        change = number, reading.capability, value
        if agreeing := entry.agreement.record(change, endpoint_of(source), entry.claimed, self._liveness.now):
            self._trust(entry, agreeing)

    def _reach(self, entry: Entry) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
        """Return whether *entry* can be reached, its unreachable parts, and its reachability at each gateway."""
        offline = entry.offline_parts(entry.parts(self._table.topics)) if entry.is_denied else ()
        return entry.reach_state(), offline, entry.endpoint_reach()

    def _post(self, entry: Entry, source: SourceRecord, place: tuple[str, str], stored: StoredValue) -> None:
        """Add a value to the postings; later changes in *stored* need no update unless another route reports it."""
        table = self._table
        if entry.id in table.outdated:
            return
        part = entry.parts(table.topics).shown_part_of(source, place[0])
        if part is not None and len(part.routes) > 1:
            table.outdated[entry.id] = None
        elif part is not None:
            table.postings.put_value(entry.id, part.id, part.part.service_type, place[1], stored)

    def _publish(self, entry: Entry, source: SourceRecord, new: list[_NewValue], report: Report) -> None:
        """Publish the new values of *report*."""
        table, live = self._table, not report.retained
        if len(entry.sources) > 1:
            for place, _, stored in new:
                self._post(entry, source, place, stored)
        if table.changes.collects_settings:
            self._settings.record(entry, source, new, _REPORTED if live else ALERTING, report.set_by)
        if not table.changes.collects_states:
            return
        merged = entry.parts(table.topics)
        readings, names = [], [entry.id]
        for place, reading, _ in new:
            if merged.has_own_ids:
                readings.append(reading)
                names += place
            elif (shown := _show(merged, source, reading)) is not None:
                readings.append(shown)
                names += (shown.part, shown.capability)
        if readings:
            table.changes.add_states((entry, merged, tuple(readings), stream_of(names), report.received_at, live))

    def _record_event(self, entry: Entry, source: SourceRecord, reading: Reading, stamp: Time) -> None:
        """Publish an event once, by however many routes it arrives; it is not a state, so queries cannot use it."""
        table, now = self._table, self._liveness.now
        if not has_capability(source, reading.part, reading.capability):
            table.counters.unknown_parts += 1
            return
        merged = entry.parts(table.topics)
        number = merged.places.get(place := (*source.key, reading.part))
        value = reading.value.plain()
        if number is None or place in merged.hidden:
            return
        entry.echoes = entry.echoes or Echoes()  # few devices report events
        if not entry.echoes.is_new((number, reading.capability, value), source.key, now):
            return
        stored = StoredValue(reading.value, value, stamp, stamp, live=True, heard_at=now)
        source.events = {**source.events, (reading.part, reading.capability): stored}
        if table.changes.collects_states:
            event = _of_part(merged.parts[number].id, reading)
            stream = stream_of((entry.id, event.part, event.capability, table.changes.event_number()))
            table.changes.add_states((entry, merged, (event,), stream, stamp, True))


def has_capability(source: SourceRecord, part_id: str, capability: str) -> bool:
    """Return whether a part with that capability was announced."""
    for part in source.sighting.parts:
        if part.id == part_id:
            return capability in map(_NAME, part.capabilities)
    return False


def store_reachability(entry: Entry, source: SourceRecord, reading: Reading, report: Report, now: float) -> None:
    """Note whether a device, or one of its parts, can be reached."""
    if reading.part and all(part.id != reading.part for part in source.sighting.parts):
        return
    value, live = reading.value.plain(), not report.retained
    answer = value if isinstance(value, bool) else None
    known = source.reach.get(reading.part)
    if known is not None and known.value is answer:
        if known.live is not live:
            known.live = live
            source.set_reach(source.reach)
        return
    source.set_reach({**source.reach, reading.part: Reach(answer, report.received_at, now, live, report.address)})
    entry.is_denied = answer is False or (entry.is_denied and is_denied(entry.sources.values()))


def is_denied(sources: Iterable[SourceRecord]) -> bool:
    """Return whether any of *sources* reports something as unreachable."""
    for source in sources:
        if source.is_lost:
            return True
        for reach in source.reach.values():
            if reach.value is False:
                return True
    return False


def _denies_life(report: Report) -> bool:
    """Return whether *report* says that something is unreachable, as a last will does and no device."""
    return any(reading.capability == REACHABLE and not reading.value.flag for reading in report.readings)


def _show(merged: MergedParts, source: SourceRecord, reading: Reading) -> Reading | None:
    """Return *reading* with the id that its part has in the device; None if that part is not shown."""
    part = merged.shown_part_of(source, reading.part)
    return None if part is None else _of_part(part.id, reading)


def _of_part(part_id: str, reading: Reading) -> Reading:
    """Return *reading* with the device's id of the part, which may differ from the announcement's."""
    if part_id == reading.part:
        return reading
    return Reading(part=part_id, capability=reading.capability, value=reading.value)


@final
class SettingChanges:
    """The changed settings until they are popped; recording another change of one costs next to nothing.

    Attributes:
        waiting: The changed settings, by the identity of the stored value.
    """

    def __init__(self, table: DeviceTable) -> None:
        self._table = table
        self.waiting: dict[int, _WaitingChange] = {}

    def record(
        self, entry: Entry, source: SourceRecord, new: Iterable[_NewValue], wanted: Container[str], set_by: SetBy = ""
    ) -> None:
        """Record the new values of *source* for the *wanted* capabilities."""
        waiting = self.waiting
        for place, reading, stored in new:
            if place[1] not in wanted or id(stored) in waiting:
                continue
            if len(waiting) < _MAX_CHANGED:
                before = self._before(entry, source, place, stored)
                change = _WaitingChange(
                    entry, source, reading, stored.since, stored.was_absent, set_by, *before, stored
                )
                waiting[id(stored)] = change
            else:
                self._table.changes.states_lost += 1

    def _before(
        self, entry: Entry, source: SourceRecord, place: tuple[str, str], stored: StoredValue
    ) -> tuple[Value, Time]:
        """Return the value before the newest in *stored*, or a newer one by another route, and since when it was."""
        newest = stored.before, stored.before_since
        if len(entry.sources) == 1:
            return newest
        places = entry.parts(self._table.topics).places
        number = places.get((*source.key, place[0]))
        for other in entry.sources.values():
            for (part, capability), value in other.values.items():
                is_same = value is not stored and capability == place[1] and places.get((*other.key, part)) == number
                if (
                    is_same
                    and value.live
                    and value.value is not None
                    and value.since.to_seconds() > newest[1].to_seconds()
                ):
                    newest = value.reported, value.since
        return newest

    def pop(self) -> Iterator[ChangedSetting]:
        """Remove and yield the changes, as for `ChangedSettings`."""
        table, waiting = self._table, self.waiting
        self.waiting = {}
        for setting in waiting.values():
            entry, first, newest = setting.entry, setting.new.value, setting.stored.reported
            if table.entries.get(entry.id) is not entry:
                continue
            part = entry.parts(table.topics).shown_part_of(setting.source, setting.new.part)
            if part is None:
                continue
            change = ChangedSetting(
                device=entry.id,
                part=part.id,
                capability=setting.new.capability,
                value=first,
                told_at=setting.since,
                was_absent=setting.was_absent,
                set_by=setting.set_by,
                before=setting.before,
                before_since=setting.before_since,
            )
            if newest is first or not (newest.number and first.number):
                yield change
                if first.plain() is not None:
                    change = change.model_copy(update={"before": first, "before_since": setting.since})
            if newest is not first:
                yield change.model_copy(update={"value": newest, "told_at": setting.stored.since})
