"""Timelines of all commanded parts, fed by the reports of their gateways."""

import math
from collections import OrderedDict, deque
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from types import MappingProxyType
from typing import Final, final

import anyio

from homebot.control import durations
from homebot.control.command import IssuedCommand, device_settings, order_of
from homebot.control.earlier_commands import EarlierCommand, commands_in_doubt
from homebot.control.gateway_feed import GatewayFeed, places_of
from homebot.control.learnt import PROFILE, LearntPersistence, Profiles
from homebot.control.timeline.cause import MAX_NEARBY, NOWHERE, Nearby, NearbyCommands
from homebot.control.timeline.facts import Attribution, Cause, Decided, GroupMessage, Order, PartRef, Reported, Sent
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.progress import CommandProgress, Undoing
from homebot.devices import Device, DevicePart, KeyValue, State
from homebot.devices.capabilities import MOMENTARY, SETTABLE
from homebot.devices.client_rights import ClientRights, is_from_person
from homebot.devices.device import FIRST_REPORTS, ChangedSetting, target_of
from homebot.devices.journal_messages import JournalEntry, KnownCause
from homebot.devices.value import PlainValue, SetBy, Value
from homebot.devices.value_comparison import related
from homebot.graph import Node
from homebot.support.bounded_map import BoundedMap
from homebot.support.time_limits import TimeLimits

_MAX_PARTS: Final = 10_000
_MAX_COMMANDS: Final = 5_000
"""Commands in all timelines, of some 5 KiB each."""
_COUNTED_EVERY: Final = 500
_NONE: Final[Mapping[str, PlainValue]] = MappingProxyType({})


@dataclass(slots=True, eq=False)
class _TrackedPart:
    timeline: PartTimeline
    target: str
    part: DevicePart
    near: tuple[str, bool] | None = None
    relevant: frozenset[str] = frozenset()
    stop_watch: Callable[[], None] = lambda: None
    timer: int = 0
    timer_at: float = math.inf


@final
class Timelines:
    """The timelines of the last 10,000 commanded parts, with 5,000 commands in all. Set the callbacks before use.

    Args:
        feed: The reports.
        learnt: The profiles of the devices are saved and restored there.

    Attributes:
        forgotten: How many commands were forgotten early as there were too many, of which the oldest go.
    """

    def __init__(self, node: Node, feed: GatewayFeed, learnt: LearntPersistence, timeout: float, settle: float) -> None:
        self._clock = node.graph.clock
        self.feed, self.learnt = feed, learnt
        self._profiles = Profiles(learnt.saver(PROFILE))
        learnt.add(PROFILE, self._profiles.restore)
        learnt.on_entries = self._restore
        self._in_doubt: dict[PartRef, list[EarlierCommand]] = {}
        self._timeout = timeout
        self._settle = settle
        self._limits = TimeLimits()
        self._uncounted = 0
        self.forgotten = 0
        self._entries: OrderedDict[PartRef, _TrackedPart] = OrderedDict()
        self._nearby: BoundedMap[str, NearbyCommands] = BoundedMap(_MAX_PARTS)
        self.on_news: Callable[[CommandProgress, Reported | None], None] = lambda *_: None
        self.on_undone: Callable[[CommandProgress, Undoing, PlainValue, Cause], None] = lambda *_: None

    async def run(self) -> None:
        """Forget ended commands every five minutes, also of parts that get no further command, until cancelled."""
        while True:
            await anyio.sleep(durations.FORGOTTEN_EVERY)
            now = self._clock.monotonic()
            for entry in self._entries.values():
                entry.timeline.forget(now)

    def of(self, device: Device, part: DevicePart) -> PartTimeline:
        """Return the timeline of a part; a new one begins with the known values."""
        self._uncounted += 1  # a command may follow
        if self._uncounted == _COUNTED_EVERY:
            self._forget_surplus()
        place = device.id, part.id
        entry = self._entries.get(place)
        if entry is None:
            entry = self._create(place, device, part)
        else:
            self._entries.move_to_end(place)
        if entry.part is not part and entry.part != part:
            self._follow(entry, part)
        if entry.near != (device.area, len(device.parts) > 1):
            self._move(entry, device)
        return entry.timeline

    def command_members(
        self, order: Order, members: Iterable[tuple[Device, DevicePart]]
    ) -> dict[PartTimeline, CommandProgress]:
        """Record a command to a group for each of its *members*; return its progress there by their timelines."""
        by_timeline: dict[PartTimeline, CommandProgress] = {}
        message = GroupMessage(order.echoed)
        for device, part in members:
            can = {capability.name: capability.readable for capability in part.part.capabilities}
            settings = {name: value for name, value in order.settings.items() if name in can}
            values = {**settings, **order.wanted}  # a member may report what its group does not
            wanted = {name: value for name, value in values.items() if can.get(name) and name not in MOMENTARY}
            own = replace(order, settings=settings or order.settings, wanted=wanted, echoed=frozenset())
            timeline = self.of(device, part)
            by_timeline[timeline] = progress = timeline.command(own, self._clock.monotonic(), is_raw=True)
            progress.transmission.group = message
        return by_timeline

    def ineffective_routes(self, device: Device) -> tuple[KeyValue, ...]:
        """Return, by part, the routes of a device that are tried last because their last commands had no effect."""
        return tuple(
            KeyValue(key=part.id, value=route.name)
            for part in device.parts
            if len(part.routes) > 1
            for route in part.routes
            if route.name in self._profiles.of(target_of(device.id, part.id)).ineffective
        )

    def schedule(self, place: PartRef) -> None:
        """Set the timer of a decided command, and save the profile."""
        self._update(self._entries[place])

    def add(self, device: Device, changes: Iterable[ChangedSetting]) -> None:
        """Add the *changes* of one part of *device*, of which there is at least one, to its timeline.

        It may begin with them, or have missed them: the part came by another gateway than when it was last commanded.
        """
        changes = sorted(changes, key=lambda change: change.told_at.to_seconds())
        part = device.part(changes[0].part)
        if part is None:
            return
        if (entry := self._entries.get((device.id, part.id))) is not None:
            if {*places_of(entry.part.routes)}.issuperset(places_of(part.routes)):
                return  # its gateways tell them
            timeline = self.of(device, part)
        else:
            before = {change.capability: change.before.plain() for change in reversed(changes)}
            entry = self._create((device.id, part.id), device, part, before)
            timeline, newest = entry.timeline, entry.timeline.unexplained_change
            if newest is not None and newest.stamp >= changes[0].told_at.to_seconds():
                timeline.unexplained_change = None
        behind = self._clock.now() - self._clock.monotonic()
        for change in changes:
            stamp, value = change.told_at.to_seconds(), change.value.plain()
            if timeline.find(change.capability, value, stamp) is None:
                at = min(stamp - behind, self._clock.monotonic())
                absent_at = at if change.was_absent else -math.inf
                timeline.report(at, stamp, change.capability, value, absent_at=absent_at, set_by=change.set_by)
        self._update(entry)

    def cause(self, change: ChangedSetting) -> Attribution | None:
        """Return the cause of a change; None if it is not known.

        One before all reports of its timeline was a person's: the command that began that answered it.
        """
        entry, stamp = self._entries.get((change.device, change.part)), change.told_at.to_seconds()
        if entry is None:
            return None
        fact = entry.timeline.find(change.capability, change.value.plain(), stamp)
        if fact is None:
            is_first = all(report.stamp >= stamp for report in islice(entry.timeline.reports, 1))
            return Attribution(Cause.PERSON) if is_first else None
        return fact.attribution

    def causes(self, devices: Container[str]) -> Iterator[KnownCause]:
        """Yield the causes of the newest changes of some devices."""
        for (device, part), entry in self._entries.items():
            for capability, fact in entry.timeline.newest.items() if device in devices else ():
                order = entry.timeline.order_of(fact.attribution.command)
                yield KnownCause(
                    device=device,
                    part=part,
                    capability=capability,
                    value=Value.of(fact.value),
                    command=fact.attribution.command,
                    issuer=order.issuer if order else "",
                    may_be_person=fact.attribution.may_be_person
                    or (order is not None and is_from_person(order.issuer, order.trigger)),
                    cause=fact.attribution.cause.value,
                )

    def _create(
        self, place: PartRef, device: Device, part: DevicePart, before: Mapping[str, PlainValue] = _NONE
    ) -> _TrackedPart:
        target = target_of(device.id, part.id)
        timeline = PartTimeline(self._profiles.of(target), self._timeout, self._settle)
        timeline.place = place
        for capability, value in before.items():
            timeline.seed(capability, value, -math.inf)
        _seed(timeline, device, part, self._clock.now(), self._clock.monotonic())
        entry = self._entries[place] = _TrackedPart(timeline, target, part)
        self._move(entry, device)
        for command in self._in_doubt.pop(place, ()):
            settings, rights = device_settings(command.settings, part.part), ClientRights()
            issued = IssuedCommand(command.id, device, part, settings, command.issuer, rights)
            behind = self._clock.now() - self._clock.monotonic()
            sent_at = [at - behind for at in command.sent_at]
            progress = timeline.command(order_of(issued), sent_at[0], last={**issued.values, **before})
            for at in sent_at:
                timeline.append(Sent(command.id, settings, at))
            progress.apply(Decided(command.id, command.ended_at - behind, command.outcome), self._settle)
        timeline.on_news, timeline.on_undone = self.on_news, self.on_undone
        self._follow(entry, part)
        if len(self._entries) > _MAX_PARTS:
            for oldest, known in self._entries.items():
                if not (known.timeline.held or any(command.is_open for command in known.timeline.active)):
                    del self._entries[oldest]
                    self._limits.discard(known.timer)
                    known.stop_watch()
                    break
        return entry

    def _forget_surplus(self) -> None:
        """Forget the oldest commands that have ended, so that there is room for the next ones."""
        self._uncounted = 0
        timelines = [entry.timeline for entry in self._entries.values() if entry.timeline.commands]
        surplus = sum(len(timeline.commands) for timeline in timelines) - (_MAX_COMMANDS - _COUNTED_EVERY)
        if surplus <= 0:
            return
        ends = sorted(command.ended_at for timeline in timelines for command in timeline.commands)
        now = self._clock.monotonic()
        for timeline in timelines:
            self.forgotten += timeline.forget_commands(now, math.nextafter(ends[surplus - 1], math.inf))

    def _restore(self, entries: Iterable[JournalEntry]) -> None:
        """Keep the commands of earlier runs that may be obeyed yet until the timelines of their parts begin."""
        self._in_doubt = commands_in_doubt(entries)

    def _move(self, entry: _TrackedPart, device: Device) -> None:
        """Let the parts of a *device* be near each other, if it has several, and in the room where it is now."""
        near = area, has_others = device.area, len(device.parts) > 1
        nearby = Nearby(
            self._commands_to(f"device {device.id}") if has_others else NOWHERE.device,
            self._commands_to(f"room {area}") if area else NOWHERE.room,
        )
        others = (self._entries.get((device.id, part.id)) for part in device.parts)
        for tracked in (entry, *filter(None, others)):
            tracked.near, tracked.timeline.nearby = near, nearby

    def _commands_to(self, place: str) -> NearbyCommands:
        known = self._nearby.get(place)
        if known is None:
            known = self._nearby[place] = deque(maxlen=MAX_NEARBY)
        return known

    def _follow(self, entry: _TrackedPart, part: DevicePart) -> None:
        entry.stop_watch()
        entry.part = part
        settings = [
            capability.name
            for capability in part.part.capabilities
            if capability.settable or capability.name in SETTABLE
        ]
        entry.relevant = frozenset([other for name in settings for other in related(name)])
        entry.stop_watch = self.feed.watch(part.routes, partial(self._on_value, entry))

    def _on_value(self, entry: _TrackedPart, capability: str, value: PlainValue, stamp: float, set_by: SetBy) -> None:
        if capability not in entry.relevant:
            return
        routes = entry.part.routes
        lost_at, absent_at = self.feed.last_loss(routes).monotonic, self.feed.last_absence(routes)
        entry.timeline.report(self._clock.monotonic(), stamp, capability, value, lost_at, absent_at, set_by)
        self._update(entry)

    def _update(self, entry: _TrackedPart) -> None:
        """Save the profile, and set the timer."""
        self._profiles.save(entry.target, entry.timeline.profile)
        at = entry.timeline.next_at
        if at < entry.timer_at:
            self._limits.discard(entry.timer)
            entry.timer_at = at
            entry.timer = self._limits.set(max(0.0, at - self._clock.monotonic()), partial(self._advance, entry))

    def _advance(self, entry: _TrackedPart) -> None:
        entry.timer_at = math.inf
        entry.timeline.advance(self._clock.monotonic())
        self._update(entry)


def _seed(timeline: PartTimeline, device: Device, part: DevicePart, now: float, monotonic: float) -> None:
    """Record the live values of *part* in its *timeline*.

    No command explains an earlier change. The first value of the part is not a change.
    """
    settable = {capability.name for capability in part.part.capabilities if capability.settable}
    states = [state for state in device.states if state.part == part.id and state.live]
    for state in states:
        age = max(0.0, now - state.told_at.to_seconds())
        timeline.seed(state.capability, state.value.plain(), monotonic - age)
    changed = [state for state in states if state.capability in settable and _is_change(state, states)]
    newest = max(changed, key=lambda one: one.since.to_seconds(), default=None)
    if newest is not None:
        since = newest.since.to_seconds()
        at = monotonic - max(0.0, now - since)
        timeline.unexplained_change = Reported(at, since, 0, newest.capability, newest.value.plain())


def _is_change(state: State, states: list[State]) -> bool:
    """Return whether *state* is a change, or the first value of a part that reported others long before."""
    since = state.since.to_seconds()
    return not state.is_first or any(since - state.since.to_seconds() > FIRST_REPORTS for state in states)
