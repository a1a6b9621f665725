"""Watches for the triggers of routines: states, presses, and the arrival of robots."""

import math
from collections.abc import AsyncIterator, Callable, Iterable, MutableMapping, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import datetime, time, tzinfo
from functools import partial
from typing import Any, Final, NamedTuple, TypeAlias, final

import anyio
from pydantic_core import from_json

from homebot.devices import Devices, RawMessage, SubscribeToTopic
from homebot.devices.device import Device, DeviceChange, State, StateChange
from homebot.devices.echoes import Echoes
from homebot.devices.follow import Follow
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.devices.names import ROBOT_POSES, gateway_of
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import Query, lasting
from homebot.devices.robot_messages import RobotPose
from homebot.devices.value import PlainValue, Reading
from homebot.devices.value_comparison import value_text
from homebot.errors import HomebotError, UsageError
from homebot.graph import Node, qos_profile_latched
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.support.bounded_map import BoundedMap
from homebot.support.folding import fold
from homebot.support.numbers import finite_number
from homebot.support.timer_queue import TimerQueue
from homebot.words.calculations import calculated
from homebot.words.house_queries import WordsQuery
from homebot.words.message_values import Comparison, MessageValue
from homebot.words.times import read_moment, read_time, shifted_moment
from homebot.words.triggers import (
    AtTimeOf,
    Becomes,
    Changes,
    MessageComes,
    PersonMoves,
    Press,
    RobotArrival,
    ValuePasses,
)

NOT_HEARD: Final = "routine.topic_not_heard"

OnStart: TypeAlias = Callable[[object], None]
"""Called with the cause."""

SunAngleOf: TypeAlias = Callable[[bool], float]
"""Returns the azimuth of the sun now, else its elevation, in degrees."""

_TEXT: Final = "text"
_MAX_ROBOTS: Final = 100
_MAX_PEOPLE: Final = 100
_MAX_VALUES: Final = 10_000
"""Values that are compared; of more, the oldest count as new."""


class Match(NamedTuple):
    """A device that has matched for long enough, and the change with which it began to."""

    device: Device
    cause: object


def follow_matches(
    node: Node, state: Becomes, store: MutableMapping[str, Any] | None = None, *, is_new: bool = False
) -> AsyncIterator[Match]:
    """Yield each device when it has matched *state* for as long as that says.

    Args:
        store: Keeps the waits for a restart: a device that waited then, and is found so, goes on.
        is_new: Whether a device that did so earlier than this call is left out, and so one that is found so, or whose
            first value matches: it may have been so before.
    """
    follow = _follow_none_left if state.is_none else _follow_each
    return follow(node, state, {} if store is None else store, is_new=is_new)


async def _follow_each(
    node: Node, state: Becomes, kept: MutableMapping[str, Any], *, is_new: bool
) -> AsyncIterator[Match]:
    clock, due = node.graph.clock, TimerQueue[str, Match]()
    began, asked = clock.monotonic(), state
    follow = Follow(node, query=state.query, text=state.text, words=WordsQuery(state.words) if state.words else None)
    while True:
        at = due.next()
        wait = math.inf if at is None else at - clock.monotonic()
        with anyio.CancelScope(deadline=anyio.current_time() + wait) as scope:
            change = await anext(follow, None)  # first, because a change reported meanwhile may end the wait
            if change is None:
                return
            device = change.device
            key = f"since {state.text} {device.id}"
            if change.kind == "removed":
                due.discard(device.id)
                kept.pop(key, None)
            elif change.kind == "appeared":
                now = clock.now()
                state = _with_length(asked, HouseView.of(node).devices)
                since = now - (clock.monotonic() - began) if is_new else -math.inf  # by the clock as it is set now
                matched_at = _matched_at(device, replace(state, query=follow.query), now, since)
                matched_at = kept.get(key, matched_at) if matched_at == -math.inf else matched_at
                if matched_at > -math.inf:
                    left = min(state.lasting, matched_at + state.lasting - now)  # the clock may have been set back
                    due.set(device.id, clock.monotonic() + left, Match(device, CURRENT_CAUSE.get()))
                    if left > 0:
                        kept[key] = matched_at
        if scope.cancelled_caught and (ended := due.pop(clock.monotonic())) is not None:
            device_id, match = ended
            kept.pop(f"since {state.text} {device_id}", None)
            yield match


async def _follow_none_left(
    node: Node, state: Becomes, kept: MutableMapping[str, Any], *, is_new: bool
) -> AsyncIterator[Match]:
    """Yield the last device that matched *state* when none has for as long as that says."""
    clock, key = node.graph.clock, f"since {state.text}"
    view, watcher = HouseView.of(node), HouseWatcher()
    view.add(watcher)
    try:
        await view.wait_until_complete()
        devices = tuple(view.devices)
        query = WordsQuery(state.words, devices).query
        matching = {device.id for device in devices if fits(query, facets_of(device))}
        able = [device for device in devices if fits(lasting(query), facets_of(device))]
        waiting: tuple[float, Match] | None = None
        asked, state = state, _with_length(state, devices)
        if able and not matching and (key in kept or not is_new):
            since = kept.get(key, _last_change(able, state, clock.now()))
            left = min(state.lasting, since + state.lasting - clock.now())
            waiting = clock.monotonic() + left, Match(able[0], CURRENT_CAUSE.get())
        follow = Follow(node, text=state.text, words=WordsQuery(state.words))
        while True:
            wait = math.inf if waiting is None else waiting[0] - clock.monotonic()
            with anyio.CancelScope(deadline=anyio.current_time() + wait) as scope:
                if (change := await anext(follow, None)) is None:
                    return
                if change.kind != "removed":
                    matching.add(change.device.id)
                    waiting = None
                    kept.pop(key, None)
                elif change.device.id in matching:
                    matching.remove(change.device.id)
                    if not matching:
                        kept[key] = clock.now()
                        state = _with_length(asked, view.devices)
                        waiting = clock.monotonic() + state.lasting, Match(change.device, CURRENT_CAUSE.get())
            if scope.cancelled_caught and waiting is not None:
                kept.pop(key, None)
                yield waiting[1]
                waiting = None
    finally:
        view.remove(watcher)


def _with_length(state: Becomes, devices: Iterable[Device]) -> Becomes:
    """Return *state* with the length that the house tells now; it never lasts for so long while that is unknown."""
    if state.length is None:
        return state
    number = value_of(state.length, tuple(devices))
    return replace(state, lasting=state.lasting * max(0.0, number) if isinstance(number, float) else math.inf)


def _last_change(devices: Sequence[Device], state: Becomes, unknown: float) -> float:
    """Return when a value that decides on *state* last changed, or *unknown*."""
    if state.is_of_reach:
        return max((device.reachable.since.to_seconds() for device in devices), default=unknown)
    decisive = [value for device in devices for value in device.states if value.capability in state.capabilities]
    return max((value.since.to_seconds() for value in decisive if value.live), default=unknown)


_FIRST_REACH_S: Final = 10.0
"""Seconds in which it is told first whether a device can be reached: after its discovery, or the start of homebot."""


def _matched_at(device: Device, state: Becomes, now: float, since: float) -> float:
    """Return since when *device* has the values of *state*; -inf if its wait was over before the time *since*."""
    cause, is_new = CURRENT_CAUSE.get(), since > -math.inf
    is_found_so = isinstance(cause, DeviceChange) and cause.kind == "appeared"
    values = [value for value in device.states if value.capability in state.capabilities and value.live]
    if state.is_of_reach:
        at = device.reachable.since.to_seconds()
        is_found_so = is_found_so or at - max(since, device.first_seen.to_seconds()) <= _FIRST_REACH_S
    elif not values:
        return -math.inf if is_new else now
    else:
        newest = max(values, key=lambda value: value.since.to_seconds())
        at = newest.since.to_seconds()
        is_found_so = (is_found_so and not newest.is_first) or device.may_be_old(newest)
    return -math.inf if is_new and (is_found_so or at + state.lasting < since) else at


def holds_for(state: Becomes, devices: Sequence[Device], now: float, *, is_none: bool, is_recent: bool = False) -> bool:
    """Return whether one of *devices*, or none, has matched *state* for as long as that says, or for less."""
    query = WordsQuery(state.words, devices).query if state.words else state.query
    state = _with_length(state, devices)
    if not is_none:
        matching = [device for device in devices if fits(query, facets_of(device))]
        ends = [_matched_at(device, state, now, -math.inf) + state.lasting for device in matching]
        return any((end > now) if is_recent else (end <= now) for end in ends)
    able = [device for device in devices if fits(lasting(query), facets_of(device))]
    is_over = _last_change(able, state, -math.inf) + state.lasting <= now
    return is_over and not any(fits(query, facets_of(device)) for device in able)


def is_press(view: HouseView, press: Press, change: object, query: Query | None = None) -> bool:
    """Return whether *change* is the event *press*.

    Args:
        query: The query for its device, if what its words mean in the house is known.
    """
    if not isinstance(change, StateChange) or not change.is_event:
        return False
    known, value = view.get(change.device), str(change.readings[0].value.plain()).casefold()
    if known is None or not change.live or press.value not in {"", value}:
        return False
    device = known.current()
    is_button = not press.part or any(part.id == change.readings[0].part for part in press.buttons(device.parts))
    return is_button and fits(
        WordsQuery(press.words, view.devices).query if query is None else query, facets_of(device)
    )


def start_watch(
    node: Node, trigger: Press | Changes | ValuePasses | PersonMoves | RobotArrival, on_start: OnStart
) -> Callable[[], None]:
    """Call *on_start* whenever *trigger* comes, until the returned function is called."""
    match trigger:
        case Press():
            return PressWatch(node, trigger, on_start).close
        case Changes():
            return ValueWatch(node, trigger, on_start).close
        case ValuePasses():
            return ComparisonWatch(node, trigger, on_start).close
        case PersonMoves():
            return PersonWatch(node, trigger, on_start).close
        case RobotArrival():
            return ArrivalWatch(node, trigger, on_start).close


@final
class PressWatch(HouseWatcher):
    """Calls a function with each event that fits a trigger, once for one that parts of several kinds tell.

    Some bridges announce a press as an event and as the trigger of a device.
    """

    def __init__(self, node: Node, press: Press, on_start: OnStart) -> None:
        self._press = press
        self._words = WordsQuery(press.words)
        self._on_start = on_start
        self._echoes = Echoes()
        self._view = HouseView.of(node)
        self._view.add(self)
        self._view.names.add(press.query, press.text)

    def close(self) -> None:
        """End the calls; idempotent."""
        self._view.remove(self)

    def on_device(self, change: DeviceChange) -> None:
        """Record the names that the words of the trigger may be."""
        self._words.record(change.device, is_gone=change.kind == "removed")

    def on_event(self, change: StateChange) -> None:
        """Start the routine if the device and the event are meant."""
        known = self._view.get(change.device)
        if known is None or not is_press(self._view, self._press, change, self._words.query):
            return
        event = change.readings[0]
        kinds = [part.part.advertised for part in known.current().parts if part.id == event.part]
        if self._echoes.is_new((change.device, event.capability), "".join(kinds), now=change.told_at.to_seconds()):
            self._on_start(change)


@final
class ValueWatch(HouseWatcher):
    """Calls a function when a device that fits reports another value than before: to be unknown is no change."""

    def __init__(self, node: Node, trigger: Changes, on_start: OnStart) -> None:
        self._node = node
        self._trigger = trigger
        self._waits: BoundedMap[tuple[str, str, str], anyio.CancelScope] = BoundedMap(_MAX_VALUES)
        self._words = WordsQuery(trigger.words)
        self._on_start = on_start
        self._values: BoundedMap[tuple[str, str, str], PlainValue] = BoundedMap(_MAX_VALUES)
        self._view = HouseView.of(node)
        self._view.add(self)
        self._view.names.add(trigger.query, trigger.text)

    def close(self) -> None:
        """End the calls; idempotent."""
        for wait in self._waits.values():
            wait.cancel()
        self._view.remove(self)

    def on_device(self, change: DeviceChange) -> None:
        """Record the names that the words of the trigger may be, and the values of a new device."""
        self._words.record(change.device, is_gone=change.kind == "removed")
        for state in change.device.states if change.kind == "appeared" else ():
            self._is_new(change.device.id, state)

    def on_values(self, change: StateChange) -> None:
        """Start the routine if one of the values is meant, and another one than before."""
        known = self._view.get(change.device)
        if known is None or not fits(self._words.query, facets_of(known.current())):
            return
        new = [reading for reading in change.readings if self._is_new(change.device, reading)]
        if not new or not change.live:
            return
        if not self._trigger.lasting:
            self._on_start(change)
            return
        for reading in new:
            wait = anyio.CancelScope()
            self._waits[change.device, reading.part, reading.capability] = wait
            self._node.create_task(partial(self._start_later, wait, change))

    async def _start_later(self, wait: anyio.CancelScope, change: StateChange) -> None:
        with wait:
            await anyio.sleep(self._trigger.lasting)
            self._on_start(change)

    def _is_new(self, device: str, reading: State | Reading) -> bool:
        if self._trigger.capability not in {"", reading.capability}:
            return False
        key, value = (device, reading.part, reading.capability), reading.value.plain()
        before = self._values.get(key)
        self._values[key] = value
        if before != value and (wait := self._waits.pop(key, None)) is not None:
            wait.cancel()
        meant = (self._trigger.before, self._trigger.after)
        is_meant = not any(meant) or meant == (fold(value_text(before)), fold(value_text(value)))
        return before is not None and before != value and is_meant


@final
class MessageWatches:
    """Calls functions with the messages on topics of MQTT, of every gateway for it, but not with a retained one."""

    def __init__(self, node: Node, devices: Devices) -> None:
        self._node = node
        self._devices = devices
        self._watches: dict[str, dict[object, tuple[MessageComes, OnStart]]] = {}

    def add(self, trigger: MessageComes, on_start: OnStart) -> Callable[[], None]:
        """Call *on_start* whenever *trigger* comes, until the returned function is called."""
        if trigger.topic not in self._watches:
            self._watches[trigger.topic] = {}
            self._node.create_task(partial(self._listen, trigger.topic))
        key = object()
        self._watches[trigger.topic][key] = trigger, on_start

        def remove() -> None:
            self._watches[trigger.topic].pop(key, None)

        return remove

    async def _listen(self, topic: str) -> None:
        """Ask each gateway, of which those of other protocols refuse."""
        services = self._node.graph.get_services_of_type(SubscribeToTopic.ros_type)
        problems: list[HomebotError] = []
        gateways = {*filter(None, (gateway_of(service.node) for service in services))}
        for gateway in sorted(gateways):
            try:
                await self._devices.listen_to(topic, self._on_message, gateway)
            except HomebotError as exc:
                problems.append(exc)
        if len(problems) == len(gateways):
            reason = problems[0] if problems else "there is no gateway"
            self._node.log.warning(NOT_HEARD, message=f"messages on {topic} start nothing: {reason}", topic=topic)

    def _on_message(self, message: RawMessage) -> None:
        if message.retained:  # its age is unknown
            return
        for trigger, on_start in tuple(self._watches.get(message.address, {}).values()):
            if is_message(trigger, message):
                on_start(CURRENT_CAUSE.get())


def is_message(trigger: MessageComes, cause: object) -> bool:
    """Return whether *cause* is the message *trigger*."""
    if not isinstance(cause, RawMessage) or cause.address != trigger.topic:
        return False
    return trigger.value is None or _text_at(cause.payload, trigger.path) == trigger.value.casefold()


def _text_at(payload: bytes, path: Sequence[str]) -> str | None:
    """Return the value at *path* in *payload* as text in lower case; None if there is none."""
    if not path:
        return payload.decode(errors="replace").strip().casefold()
    try:
        value: object = from_json(payload)
    except ValueError:
        return None
    for name in path:
        value = value.get(name) if isinstance(value, dict) else None
    if isinstance(value, float):
        return f"{value:.12g}"
    return str(value).casefold() if isinstance(value, bool | int | str) else None


@final
class TimeOfWatch(HouseWatcher):
    """Keeps a call at the time, of each day or one, that the text of a device tells; another text makes no call."""

    def __init__(
        self, node: Node, trigger: AtTimeOf, zone: tzinfo, call_at: Callable[[str], Callable[[], None]]
    ) -> None:
        self._trigger = trigger
        self._zone = zone
        self._words = WordsQuery(trigger.words)
        self._call_at = call_at
        self._at = ""
        self._cancel: Callable[[], None] = lambda: None
        self._view = HouseView.of(node)
        self._view.add(self)
        self._view.names.add(trigger.query, trigger.text)

    def close(self) -> None:
        """End the calls; idempotent."""
        self._cancel()
        self._view.remove(self)

    def on_device(self, change: DeviceChange) -> None:
        """Record the names that the words of the trigger may be, and the text of a new device."""
        self._words.record(change.device, is_gone=change.kind == "removed")
        self._read(change.device, change.device.states)

    def on_values(self, change: StateChange) -> None:
        """Call at another time if the text is meant."""
        if any(reading.capability == self._trigger.capability for reading in change.readings) and change.live:
            known = self._view.get(change.device)
            self._read(None if known is None else known.current(), change.readings)

    def _read(self, device: Device | None, readings: Sequence[State | Reading]) -> None:
        if device is None or not fits(self._words.query, facets_of(device)):
            return
        texts = [str(reading.value.plain()) for reading in readings if reading.capability == self._trigger.capability]
        if not texts or texts[0] == self._at:
            return
        self._cancel()
        self._at, self._cancel = texts[0], lambda: None
        with suppress(UsageError):
            self._cancel = self._call_at(shifted_moment(self._at, self._trigger.offset, self._zone))


@final
class ComparisonWatch(HouseWatcher):
    """Calls a function when a comparison of two values begins to hold: it must have been known not to.

    With a length of time it must hold for so long, and be known.
    """

    def __init__(self, node: Node, trigger: ValuePasses, on_start: OnStart) -> None:
        self._node = node
        self._trigger = trigger
        self._on_start = on_start
        self._held: bool | None = None
        self._wait = anyio.CancelScope()
        self._view = HouseView.of(node)
        self._view.add(self)
        for value in (trigger.comparison.first, trigger.comparison.second):
            self._view.names.add(value.query, trigger.text)

    def close(self) -> None:
        """End the calls; idempotent."""
        self._wait.cancel()
        self._view.remove(self)

    def on_device(self, change: DeviceChange) -> None:
        """Compare the values of a new device, or those that a removed one leaves."""
        if any(self._is_meant(state) for state in change.device.states):
            self._begins()

    def on_values(self, change: StateChange) -> None:
        """Start the routine if one of the values is meant, and the comparison begins to hold."""
        if not any(map(self._is_meant, change.readings)) or not self._begins():
            return
        if self._trigger.lasting:
            self._wait = anyio.CancelScope()
            self._node.create_task(partial(self._start_later, self._wait, change))
        else:
            self._on_start(change)

    async def _start_later(self, wait: anyio.CancelScope, change: StateChange) -> None:
        with wait:
            await anyio.sleep(self._trigger.lasting)
            self._on_start(change)

    def _is_meant(self, reading: State | Reading) -> bool:
        comparison = self._trigger.comparison
        return reading.capability in {comparison.first.capability, comparison.second.capability}

    def _begins(self) -> bool:
        """Return whether the comparison begins to hold; what is unknown in between begins nothing."""
        holds = compared(self._trigger.comparison, tuple(self._view.devices))
        if not holds:
            self._wait.cancel()
        if holds is None:
            return False
        before, self._held = self._held, holds
        return holds and before is False


def compared(comparison: Comparison, devices: Sequence[Device], sun: SunAngleOf | None = None) -> bool | None:
    """Return whether *comparison* holds for the values of *devices*; None while one is unknown."""
    first, second = (value_of(value, devices, sun) for value in (comparison.first, comparison.second))
    if not isinstance(first, float) or not isinstance(second, float):
        return None
    limit = second + comparison.offset
    return (first > limit if comparison.is_above else first < limit) is not comparison.is_denied


def fitting(words: str, devices: Sequence[Device]) -> list[Device]:
    """Return those of *devices* that the query *words* means."""
    query = WordsQuery(words, devices).query
    return [device for device in devices if fits(query, facets_of(device))]


def value_of(value: MessageValue, devices: Sequence[Device], sun: SunAngleOf | None = None) -> PlainValue:
    """Return *value* of the first of *devices* that it means; None while it is unknown."""
    match value.kind:
        case "count":
            return float(len(fitting(value.words, devices)))
        case "sun":
            return sun(value.words == "azimuth") if sun is not None else None
        case "calculated":
            numbers = {one.text: value_of(one, devices, sun) for one in value.operands}
            return calculated(value.term, lambda text: finite_number(numbers[text]))
    states = [state for device in fitting(value.words, devices) for state in device.states]
    return next((state.value.plain() for state in states if state.capability == value.capability and state.live), None)


def time_of(end: time | MessageValue, devices: Sequence[Device]) -> time | None:
    """Return the time of day *end*, which a text of the house may tell; None while that is none."""
    if isinstance(end, time):
        return end
    with suppress(UsageError):
        return read_time(value_of(end, devices))
    return None


def moment_of(value: MessageValue, devices: Sequence[Device], zone: tzinfo) -> float | None:
    """Return the moment that a text of the house tells, in seconds since the Unix epoch; None if it tells no day."""
    with suppress(UsageError):
        clock, day = read_moment(str(value_of(value, devices)))
        if day is not None:
            return datetime.combine(day, read_time(clock), zone).timestamp()
    return None


@final
class PersonWatch(HouseWatcher):
    """Calls a function when a person, or the household, moves: to be unknown in between is no move."""

    def __init__(self, node: Node, move: PersonMoves, on_start: OnStart) -> None:
        self._move = move
        self._on_start = on_start
        self._was_home: BoundedMap[str, bool] = BoundedMap(_MAX_PEOPLE)
        self._view = HouseView.of(node)
        self._view.add(self)
        self._view.names.add(move.query, move.text)

    def close(self) -> None:
        """End the calls; idempotent."""
        self._view.remove(self)

    def on_device(self, change: DeviceChange) -> None:
        """Record the place of a new person."""
        self._record(change.device.id, change)

    def on_values(self, change: StateChange) -> None:
        """Start the routine if a person was elsewhere before."""
        if any(reading.capability == self._move.fact for reading in change.readings):
            self._record(change.device, change)

    def _record(self, device_id: str, change: DeviceChange | StateChange) -> None:
        known = self._view.get(device_id)
        device = None if known is None else known.current()
        if device is None or not fits(self._move.query, facets_of(device)):
            return
        states = [state for state in device.states if state.capability == self._move.fact and state.live]
        if states and isinstance(is_home := states[0].value.plain(), bool):
            before = self._was_home.get(device_id)
            self._was_home[device_id] = is_home
            if before is not None and before is not is_home and is_home is self._move.is_home:
                self._on_start(change)


@final
class ArrivalWatch:
    """Calls a function when a robot comes into a room, or goes out of it."""

    def __init__(self, node: Node, arrival: RobotArrival, on_start: OnStart) -> None:
        self._arrival = arrival
        self._on_start = on_start
        self._rooms: BoundedMap[str, str] = BoundedMap(_MAX_ROBOTS)
        self._poses = node.create_subscription(RobotPose, ROBOT_POSES, self._on_pose, qos_profile_latched)

    def close(self) -> None:
        """End the calls; idempotent."""
        self._poses.close()

    def _on_pose(self, pose: RobotPose) -> None:
        arrival, room = self._arrival, fold(pose.room) if pose.counts and not pose.is_nearest_room else ""
        if arrival.robot not in {"robot", pose.robot.casefold()}:
            return
        before = self._rooms.get(pose.robot)
        self._rooms[pose.robot] = room
        wanted = fold(arrival.room)
        if before is not None and room != before and wanted == (before if arrival.leaves else room):
            self._on_start(CURRENT_CAUSE.get())
