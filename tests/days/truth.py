"""The truth of a simulated house: each command that reached a device, and who was there; no sensor is asked.

Beside it stands what the motion sensors and contacts said: where all seem to work and say that nobody is there, or that
a window is closed, nobody knows better.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from tests.days.random_day import RandomDay
from tests.days.told import RECONNECTED, Told

from homebot.house import World
from homebot.house.devices import CoverMotor, SimulatedThermostat
from homebot.house.event_log import Event, WorldLog
from homebot.house.faults import unwrap
from homebot.house.sensors import MotionSensor, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.support.numbers import to_number

_ROUNDING: Final = 1e-6
"""Seconds that clocks round off."""

_OFF: Final = frozenset({"off", "0"})


@dataclass(frozen=True, slots=True)
class TruthfulCommand:
    """A command that reached a device over its radio.

    Attributes:
        at: Seconds since the first midnight.
        device: Its name.
        kind: Its kind, such as ``lamp``.
        command: In the words of the house.
        id: The id that it carried, by which it is in the journal; empty for what did not come from homebot.
        room: Where the device is.
        awake: How many people are awake there.
        is_unseen: Whether the motion sensors there, all of which have detected somebody before and seem to work, have
            long said that nobody is there, and the contacts on its doors do not show that somebody stayed.
        is_switched: Whether a hand has changed at this very moment what the device reports.
        is_open: Whether a door or window with a contact there is open.
        is_told_open: Whether one of these contacts has said so for a second, or fell silent.
        is_ever_told_open: Whether each of these contacts has said ``open`` before: one that never has may be broken.
        position: How far a cover is open, from 0 to 1; 0 for everything else.
        target: Degrees Celsius that a thermostat was set to before; 0 for everything else.
    """

    at: float
    device: str
    kind: str
    command: str
    id: str
    room: str
    awake: int
    is_unseen: bool
    is_switched: bool
    is_open: bool
    is_told_open: bool
    is_ever_told_open: bool
    position: float
    target: float


class GroundTruth(WorldLog):
    """Takes the place of the event log of a house, and looks at people and doors when a device gets a command.

    Args:
        world: The house, before its first day.
        day: What happens in it, and what homebot is told of it.
    """

    def __init__(self, world: World, day: RandomDay) -> None:
        super().__init__()
        self.commands: list[TruthfulCommand] = []
        self._world = world
        self._day = day
        self._told: dict[str, Told] = {}
        self._said: dict[str, str] = {}
        self._pressed: dict[str, float] = {}
        self._switched: dict[str, float] = {}
        self._told_last: dict[str, str] = {}  # what the last command since a hand was there makes a device report
        self._began = 0.0

    def begin(self) -> None:
        """Let the sensors say how they are, as they do when homebot starts."""
        self.commands.clear()
        self._began = self._world.now
        for name, placed in self._world.devices.items():
            self._said[name] = placed.device.state()
            if isinstance(unwrap(placed.device), MotionSensor | SimulatedContactSensor):
                self._told[name] = Told(self._began)
                if placed.device.has_power:
                    self._told[name].take(placed.device.state(), self._began)

    def add(self, event: Event) -> None:
        """Write *event* down."""
        super().add(event)
        if event.verb == "says" and event.who in self._told:
            self._told[event.who].take(event.what, event.at)
        if event.verb == "power" and event.who in self._told:
            self._told[event.who].power_at = event.at
        if event.verb == "switch":
            self._pressed[event.who] = event.at
            self._told_last.pop(event.who, None)
        if event.verb == "says":
            is_by_hand = self._pressed.get(event.who) == event.at and self._told_last.get(event.who) != event.what
            if event.what != self._said.get(event.who) and is_by_hand:
                self._switched[event.who] = event.at
            self._said[event.who] = event.what
        if event.verb == "told":
            self.commands.append(self._seen(event))
            self._told_last[event.who] = _reported_after(event.what)

    def _seen(self, event: Event) -> TruthfulCommand:
        placed = self._world.devices[event.who]
        real = unwrap(placed.device)
        opened = [name for name in self._sensors(placed.room, SimulatedContactSensor) if self._world.is_open(name)]
        return TruthfulCommand(
            event.at,
            event.who,
            real.kind,
            event.what,
            event.command,
            placed.room,
            self._world.awake_in(placed.room),
            self._is_unseen(placed.room, event.at),
            self._switched.get(event.who) == event.at,
            bool(opened),
            any(self._is_told_open(name, event.at) for name in opened),
            all(self._told[name].has_opened for name in opened),
            real.position_at(event.at) if isinstance(real, CoverMotor) else 0.0,
            real.target if isinstance(real, SimulatedThermostat) else 0.0,
        )

    def _sensors(self, room: str, kind: type[SimulatedDevice]) -> list[str]:
        devices = self._world.devices
        return [
            name for name in self._told if devices[name].room == room and isinstance(unwrap(devices[name].device), kind)
        ]

    def _is_unseen(self, room: str, now: float) -> bool:
        sensors = self._sensors(room, MotionSensor)
        is_quiet = bool(sensors) and all(self._says_nobody(name, now) for name in sensors)
        return is_quiet and not self._shows_stay(room, sensors, now)

    def _says_nobody(self, name: str, now: float) -> bool:
        told = self._told[name]
        is_quiet = told.clear_for(now) >= self._day.absent_after - _ROUNDING
        return is_quiet and now < told.silence_known_from(self._world.devices[name], self._began)

    def _shows_stay(self, room: str, sensors: Sequence[str], now: float) -> bool:
        """Return whether somebody moved in *room* after its doors were closed, by what its sensors surely told."""
        contacts = self._day.doors.get(room, ())
        if not contacts or not all(self._says_closed(name, now) for name in contacts):
            return False
        closed = max(self._told[name].at for name in contacts)
        in_touch = max(self._in_touch_since(name, now) for name in (*contacts, *sensors))
        return any(self._told[name].moved_since(max(closed, in_touch), self._day.absent_after) for name in sensors)

    def _says_closed(self, name: str, now: float) -> bool:
        told = self._told[name]
        away = [(event.at, event.lasts) for event in self._day.day.happenings if event.what == "restart"]
        is_trusted = now < told.trusted_until(self._world.devices[name], self._began)
        return told.word == "closed" and is_trusted and told.is_heard_again(now, away)

    def _in_touch_since(self, name: str, now: float) -> float:
        """Return since when nothing that a sensor said was lost on its way; later than *now* while that may be so."""
        lost = (
            event.at + event.lasts + RECONNECTED
            for event in self._day.day.happenings
            if event.at <= now and (event.what == "restart" or (event.what == "cut" and event.device == name))
        )
        return max(lost, default=self._began)

    def _is_told_open(self, name: str, now: float) -> bool:
        told = self._told[name]
        if told.word == "open":
            return now - told.at > 1.0
        is_known = bool(told.word)  # homebot has never heard of one that had no power from the beginning
        return is_known and now >= told.silence_known_from(self._world.devices[name], self._began)


def _reported_after(command: str) -> str:
    """Return what a lamp reports after *command*; of another device the command, which is what most report."""
    brightness = to_number(command)
    if brightness is None:
        return command
    return "on" if brightness > 0 else "off"


def is_off(command: TruthfulCommand) -> bool:
    """Return whether a lamp is told to be dark."""
    return command.kind == "lamp" and command.command in _OFF


def is_on(command: TruthfulCommand) -> bool:
    """Return whether a lamp is told to shine; a colour alone does not."""
    return command.kind == "lamp" and not is_off(command) and not command.command.endswith("K")


def annoys(command: TruthfulCommand) -> bool:
    """Return whether an app may not do that where somebody is: a lamp goes dark, or a cover goes down."""
    if command.kind == "cover":
        return command.command == "close" or (command.command == "0" and command.position > 0)
    return is_off(command)


def heats(command: TruthfulCommand) -> bool:
    """Return whether a thermostat is told to be warmer than it was set to."""
    wanted = to_number(command.command)
    return command.kind == "thermostat" and wanted is not None and wanted > command.target
