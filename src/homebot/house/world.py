"""The world of a simulated house: its people, its devices and the sun, on one timeline.

Everything happens in :meth:`World.run_until`, :meth:`World.command` and :meth:`World.press`, in order of time, and is
recorded in one event log. The same house, seed and commands at the same times give the same log.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from homebot.errors import UsageError
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat
from homebot.house.event_log import Event, Verb, WorldLog
from homebot.house.faults import unwrap
from homebot.house.household import Household, Person
from homebot.house.rooms import DAY, OUTSIDE, REAL_TIME, Room, Rooms, WorldTime, daylight, weather
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, PresenceSensor, SimulatedContactSensor
from homebot.house.simulated_device import Drive, Placed, ScheduledCommand, SimulatedDevice
from homebot.support.timer_queue import TimerQueue

SAMPLE = 300.0
"""Seconds between updates of sun and weather."""

DARK = 30.0
"""Lux below which people switch on a lamp."""

MAX_COMMAND_CHARACTERS = 200
"""Most characters of a text, since the event log keeps commands."""

ERRAND_RETRY_S = 60.0
"""Seconds after which an errand that waits for a reserved device is tried again."""

DOOR_CLOSES = 3.0
DOOR_LOCKS = 15.0
"""Seconds after a person passed."""


@dataclass(eq=False)
class _PlacedDevice:
    """A device, the real device under its faults, and the state of its door.

    The door is open until ``open_until`` after a person passed, and while ``left_open`` by hand.
    """

    placed: Placed
    real: SimulatedDevice
    open_until: float = 0.0
    left_open: bool = False


class World:
    """A simulated house over time.

    Args:
        errands: Daily timers.
        seed: Determines the jitter of its people; faults have their own random numbers.
        first_day: Day of the year, 1 to 366.
        latitude: Degrees north.
        by_hand: Whether people switch lamps on when entering a dark room, and off when leaving.
        forgetful: Whether they leave lamps on when leaving or falling asleep.
        time: The relation of its time to the clock, on a network.
        capacity: Most events in the event log.

    Attributes:
        now: Seconds since the midnight before the first day.

    Raises:
        UsageError: Two devices have one name, or a room or device is not there.
    """

    def __init__(
        self,
        rooms: Rooms,
        placed: Iterable[Placed],
        people: Sequence[Person] = (),
        errands: Sequence[ScheduledCommand] = (),
        *,
        seed: int = 0,
        first_day: int = 80,
        latitude: float = 48.0,
        by_hand: bool = True,
        forgetful: bool = False,
        time: WorldTime = REAL_TIME,
        capacity: int = 100_000,
    ) -> None:
        self.now, self.time = 0.0, time
        self.event_log = WorldLog(capacity)
        self.rooms = rooms
        self._entries: dict[str, _PlacedDevice] = {}
        for item in placed:
            if item.device.device_id in self._entries:
                raise UsageError(f"two devices are called {item.device.device_id!r}")
            self._entries[item.device.device_id] = _PlacedDevice(item, unwrap(item.device))
        self._errands = errands
        self._seed = seed
        self._first_day = first_day
        self._latitude = latitude
        self._by_hand = by_hand
        self._forgetful = forgetful
        self._check()
        self._in_room = {room: [t for t in self._entries.values() if t.placed.room == room] for room in rooms.rooms}
        self._was_dark: dict[str, bool] = {}
        self._queue: TimerQueue[object, Callable[[], None]] = TimerQueue()
        self._household = Household(people, rooms, self._queue, lambda: self.now, self)
        self._queue.set(object(), 0.0, partial(self._begin_day, 0))
        self._queue.set(object(), 0.0, self._sample)
        for entry in self._entries.values():
            self._plan_step(entry)

    @classmethod
    def of(cls, *devices: SimulatedDevice) -> World:
        """Return a house of one room with *devices* and no people.

        Raises:
            UsageError: Two devices have one name.
        """
        return cls(
            Rooms({OUTSIDE: Room(window=1.0), "room": Room()}, []), [Placed(device, "room") for device in devices]
        )

    @property
    def devices(self) -> Mapping[str, Placed]:
        """The devices by name, in their original order."""
        return {name: entry.placed for name, entry in self._entries.items()}

    def next_event(self) -> float:
        """Return the time of the next event, at most a few minutes ahead."""
        at = self._queue.next()
        return self.now + SAMPLE if at is None else at

    def run_until(self, now: float) -> tuple[Event, ...]:
        """Run everything due until *now*, and return the events; time never goes back.

        Raises:
            UsageError: *now* is no finite number.
        """
        if not math.isfinite(now):
            raise UsageError(f"a house cannot run back to {now}")
        mark = self.event_log.count
        while (at := self._queue.next()) is not None and at <= now:
            self.now = max(self.now, at)
            if (due := self._queue.pop()) is not None:
                due[1]()
        self.now = max(self.now, now)
        return self.event_log.since(mark)

    def command(self, device_id: str, command: str, now: float, command_id: str = "") -> tuple[Event, ...]:
        """Run until *now*, then give *command*, which may have an id, to a device; return all that happened.

        Raises:
            UsageError: There is no such device, or *now* is no finite number.
        """
        entry = self._find(device_id)
        mark = self.event_log.count
        self.run_until(now)
        self._command(entry, command, command_id)
        entry.real.last_sender = "a command"
        return self.event_log.since(mark)

    def press(self, device_id: str, command: str, now: float) -> tuple[Event, ...]:
        """Run until *now*, then operate a device by hand, as by *command*; otherwise as :meth:`command`."""
        entry = self._find(device_id)
        mark = self.event_log.count
        self.run_until(now)
        self._switch(entry, command)
        entry.real.last_sender = "a hand"
        return self.event_log.since(mark)

    def families(self) -> tuple[str, ...]:
        """Return the families of its devices, each once."""
        return tuple(dict.fromkeys(placed.dialect for placed in self.devices.values()))

    def device(self, device_id: str) -> SimulatedDevice:
        """Return a device, with its faults, at :attr:`now`.

        Raises:
            UsageError: There is no such device.
        """
        device = self._find(device_id).placed.device
        device.advance(self.now)
        return device

    def people_in(self, room: str) -> tuple[str, ...]:
        """Return the people in *room*, asleep or not."""
        return self._household.people_in(room)

    def awake_in(self, room: str) -> int:
        """Return how many are awake in *room*."""
        return self._household.awake_in(room)

    def is_open(self, device_id: str) -> bool:
        """Return whether the door or window of a contact is actually open, also where the contact reports otherwise.

        Raises:
            UsageError: There is no such device.
        """
        entry = self._find(device_id)
        return entry.left_open or self.now < entry.open_until

    def lux(self, room: str) -> float:
        """Return the illuminance of *room*: sunlight through windows and covers, and its lamps.

        Raises:
            UsageError: There is no such room.
        """
        if room not in self._in_room:
            raise UsageError(f"there is no room {room!r}")
        entries = self._in_room[room]
        covers = [entry.real.position_at(self.now) for entry in entries if isinstance(entry.real, CoverMotor)]
        let_in = sum(covers) / len(covers) if covers else 1.0
        sun = daylight(self.now, self._first_day, self._latitude) * self.rooms.rooms[room].window * let_in
        lamps = [t.real for t in entries if isinstance(t.real, SimulatedLamp) and t.placed.device.watts() > 0]
        return sun + sum(lamp.lux() for lamp in lamps)

    def on_door_passed(self, name: str, left: str, entered: str) -> None:
        """Open the door through which a person passes: its contact reports, its lock works. For the household."""
        self._record(name, "enters", entered)
        for entry in self._at_door(left, entered):
            if isinstance(entry.real, SimulatedContactSensor):
                self._open(entry)
            elif isinstance(entry.real, SimulatedDoorLock):
                self._switch(entry, "unlock")
                entry.open_until = self.now + DOOR_LOCKS
                self._queue.set(object(), entry.open_until, partial(self._close, entry))

    def on_sleep(self, name: str, room: str) -> None:
        """Log a person falling asleep. For the household."""
        self._record(name, "sleeps", room)

    def on_motion(self, room: str) -> None:
        """Report motion in *room* to its sensors, and operate its lamps by hand. For the household."""
        self._show_motion(room)
        wish = self._wish(room) if self._by_hand and room != OUTSIDE else ""
        for entry in self._in_room[room] if wish else ():
            if isinstance(entry.real, SimulatedLamp) and entry.real.state() != wish:
                self._switch(entry, wish)

    def _wish(self, room: str) -> str:
        """Return the command of the people in *room* to its lamps; empty for none."""
        if self._household.awake_in(room):
            return "on" if self.lux(room) < DARK else ""
        return "" if self._forgetful else "off"

    def on_still(self, room: str) -> None:
        """Report the end of motion to the sensors of *room*. For the household."""
        self._show_motion(room)

    def _check(self) -> None:
        for entry in self._entries.values():
            for room in (entry.placed.room, entry.placed.door or entry.placed.room):
                self.rooms.path(room, room)
            if isinstance(entry.real, PowerMeter) and entry.real.of:
                self._find(entry.real.of)
        for scheduled in self._errands:
            self._find(scheduled.device_id)

    def _find(self, device_id: str) -> _PlacedDevice:
        if device_id not in self._entries:
            raise UsageError(f"there is no device {device_id!r}")
        return self._entries[device_id]

    def _begin_day(self, day: int) -> None:
        self._household.begin_day(day, str(self._seed))
        for scheduled in self._errands:
            entry = self._entries[scheduled.device_id]
            self._queue.set(object(), day * DAY + scheduled.at, partial(self._run_errand, entry, scheduled.command))
        self._queue.set(object(), (day + 1) * DAY, partial(self._begin_day, day + 1))

    def _run_errand(self, entry: _PlacedDevice, command: str) -> None:
        """Give *command*, once the device is no longer reserved."""
        if self.now < entry.real.reserved_until:
            self._queue.set(object(), self.now + ERRAND_RETRY_S, partial(self._run_errand, entry, command))
            return
        self._command(entry, command)
        entry.real.last_sender = "an errand of the house"

    def _at_door(self, room: str, other: str) -> list[_PlacedDevice]:
        """Return the entries on the door between two rooms; none if they are the same."""
        near = (*self._devices_in(room), *self._devices_in(other)) if room != other else ()
        return [entry for entry in near if {entry.placed.room, entry.placed.door} == {room, other}]

    def _devices_in(self, room: str) -> list[_PlacedDevice]:
        return self._in_room.get(room, [])  # a robot may have a larger plan

    def _open(self, contact: _PlacedDevice) -> None:
        self._feel(contact, 1.0)
        contact.open_until = self.now + DOOR_CLOSES
        self._queue.set(object(), contact.open_until, partial(self._close, contact))

    def _close(self, entry: _PlacedDevice) -> None:
        if self.now < entry.open_until:
            return  # another person has passed
        if isinstance(entry.real, SimulatedContactSensor):
            self._feel(entry, float(entry.left_open))
        else:
            self._switch(entry, "lock")

    def _command(self, entry: _PlacedDevice, command: str, command_id: str = "") -> None:
        command = command[:MAX_COMMAND_CHARACTERS]
        self._record(entry.placed.device.device_id, "told", command, command_id)
        self._act(entry, lambda device: device.handle_command(command, self.now))

    def _switch(self, entry: _PlacedDevice, command: str) -> None:
        command = command[:MAX_COMMAND_CHARACTERS]
        self._record(entry.placed.device.device_id, "switch", command)
        if isinstance(entry.real, SimulatedContactSensor) and command in {"open", "close"}:
            entry.left_open, entry.open_until = command == "open", self.now
            self._feel(entry, float(entry.left_open))
            return
        self._act(entry, lambda device: device.operate_manually(command, self.now))

    def _feel(self, entry: _PlacedDevice, value: float) -> None:
        self._act(entry, lambda device: device.apply_input(value, self.now))

    def _act(self, entry: _PlacedDevice, act: Callable[[SimulatedDevice], tuple[str, ...]]) -> None:
        device = entry.placed.device
        drew, had_power, before = device.watts(), device.has_power, entry.real.drive
        reports = act(device)
        if device.has_power != had_power:
            self._record(device.device_id, "power", "on" if device.has_power else "off")
        for report in reports if device.has_power else ():
            self._record(device.device_id, "says", report)
        self._plan_step(entry)
        if isinstance(entry.real, SimulatedLamp | CoverMotor):
            self._show_light(entry.placed.room)
        if device.watts() != drew:
            self._show_power()
        if (after := entry.real.drive) != before:
            # a robot sets out, arrives or stops; it cannot operate locks
            for sensor in self._at_door(before.room, after.room):
                if isinstance(sensor.real, SimulatedContactSensor):
                    self._open(sensor)
            for room in dict.fromkeys((before.room, after.room)):
                self._show_motion(room)

    def _plan_step(self, entry: _PlacedDevice) -> None:
        device = entry.placed.device
        at = device.next_event()
        if at is None:
            self._queue.discard(device.device_id)
        elif at != self._queue.time_of(device.device_id):  # otherwise it keeps its turn among simultaneous events
            self._queue.set(device.device_id, at, partial(self._act, entry, self._advance))

    def _advance(self, device: SimulatedDevice) -> tuple[str, ...]:
        return device.advance(self.now)

    def _show_motion(self, room: str) -> None:
        drives = sum(entry.real.drive == Drive(room, drives=True) for entry in self._entries.values())
        for entry in self._devices_in(room):
            if isinstance(entry.real, PresenceSensor):
                self._feel(entry, float(len(self._household.people_in(room)) + drives))
            elif isinstance(entry.real, MotionSensor):
                self._feel(entry, float(self._household.moving_in(room) + drives))

    def _show_light(self, room: str) -> None:
        for entry in self._in_room[room]:
            if isinstance(entry.real, LuxSensor):
                self._feel(entry, self.lux(room))

    def _show_power(self) -> None:
        total = sum(entry.placed.device.watts() for entry in self._entries.values())
        for entry in self._entries.values():
            if isinstance(entry.real, PowerMeter):
                of = entry.real.of
                self._feel(entry, self._entries[of].placed.device.watts() if of else total)

    def _sample(self) -> None:
        outside = weather(self.now, self._first_day)
        for entry in self._entries.values():
            if isinstance(entry.real, SimulatedThermostat):
                self._feel(entry, outside)
        self._show_power()
        for room in self.rooms.rooms:
            self._show_light(room)
            is_dark = self.lux(room) < DARK
            if is_dark and self._was_dark.get(room) is False:
                self._household.stir(room)  # a person sitting there gets up for the switch
                self.on_motion(room)
            self._was_dark[room] = is_dark
        self._queue.set(object(), self.now + SAMPLE, self._sample)

    def _record(self, subject: str, verb: Verb, fact: str, command_id: str = "") -> None:
        self.event_log.add(Event(self.now, subject, verb, fact, command_id))
