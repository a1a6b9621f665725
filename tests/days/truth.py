"""The truth of a simulated house: each command that reached a device, and who was there; no sensor is asked.

Beside it stands what the motion sensors said: where all seem to work and say that nobody is there, nobody knows better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from homebot.house import World
from homebot.house.devices import CoverMotor
from homebot.house.event_log import Event, WorldLog
from homebot.house.faults import Silent, unwrap
from homebot.house.placed import Placed
from homebot.house.sensors import MotionSensor, SimulatedContactSensor

__all__ = ["GroundTruth", "TruthfulCommand", "annoys", "is_off", "is_on"]

_NOTICED: Final = 120.0
"""Seconds after which a device that lost its link is known to be away, and by which silence may be noticed later."""

_STALE: Final = 3600.0
_STALE_ONLINE: Final = 86_400.0
"""Seconds of silence after which a device is stale: one that says when it is online is for a day longer trusted."""

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
            long said that nobody is there.
        is_open: Whether a contact sensor there has been open for a second.
        position: How far a cover is open, from 0 to 1; 0 for everything else.
    """

    at: float
    device: str
    kind: str
    command: str
    id: str
    room: str
    awake: int
    is_unseen: bool
    is_open: bool
    position: float


class GroundTruth(WorldLog):
    """Takes the place of the event log of a house, and looks at people and doors when a device gets a command.

    Args:
        world: The house, before its first day.
        absent_after: Seconds after which a sensor that says that nobody is there is believed.
    """

    def __init__(self, world: World, absent_after: float) -> None:
        super().__init__()
        self.commands: list[TruthfulCommand] = []
        self._world = world
        self._absent_after = absent_after
        self._opened: dict[str, float] = {}
        self._told: dict[str, _Told] = {}
        self._began = 0.0

    def begin(self) -> None:
        """Let the sensors say how they are, as they do when homebot starts."""
        self.commands.clear()
        self._began = self._world.now
        for name, placed in self._world.devices.items():
            if isinstance(unwrap(placed.device), MotionSensor):
                self._told[name] = _Told(self._began)
                if placed.device.has_power:
                    self._told[name].take(placed.device.state(), self._began)

    def add(self, event: Event) -> None:
        """Write *event* down."""
        super().add(event)
        if event.verb == "says" and event.what in {"open", "closed"}:
            self._opened.setdefault(event.who, event.at)
            if event.what == "closed":
                del self._opened[event.who]
        if event.verb == "says" and event.who in self._told:
            self._told[event.who].take(event.what, event.at)
        if event.verb == "power" and event.who in self._told:
            self._told[event.who].power_at = event.at
        if event.verb == "told":
            self.commands.append(self._seen(event))

    def _seen(self, event: Event) -> TruthfulCommand:
        placed = self._world.devices[event.who]
        real = unwrap(placed.device)
        return TruthfulCommand(
            event.at,
            event.who,
            real.kind,
            event.what,
            event.command,
            placed.room,
            self._world.awake_in(placed.room),
            self._is_unseen(placed.room, event.at),
            any(self._is_open(name, placed.room, event.at) for name in self._opened),
            real.position_at(event.at) if isinstance(real, CoverMotor) else 0.0,
        )

    def _is_unseen(self, room: str, now: float) -> bool:
        sensors = [name for name in self._told if self._world.devices[name].room == room]
        return bool(sensors) and all(self._says_nobody(name, now) for name in sensors)

    def _says_nobody(self, name: str, now: float) -> bool:
        told, placed = self._told[name], self._world.devices[name]
        is_quiet = told.has_detected and told.word == "clear" and now - told.at >= self._absent_after
        return is_quiet and now < told.heard_until(placed, self._began)

    def _is_open(self, name: str, room: str, now: float) -> bool:
        placed = self._world.devices[name]
        real = unwrap(placed.device)
        is_there = placed.room == room and isinstance(real, SimulatedContactSensor) and real.is_open
        return is_there and now - self._opened[name] > 1.0


@dataclass(slots=True)
class _Told:
    """What a motion sensor said."""

    at: float
    word: str = ""
    has_detected: bool = False
    power_at: float = 0.0

    def take(self, word: str, at: float) -> None:
        self.word, self.at = word, at
        self.has_detected = self.has_detected or word == "motion"

    def heard_until(self, placed: Placed, began: float) -> float:
        """Return when it must be known that nothing is heard of the sensor any more."""
        tells_link = placed.dialect != "thesis"
        device = placed.device
        if not device.has_power:
            return self.power_at + (_NOTICED if tells_link else _STALE + _NOTICED)
        if isinstance(device, Silent) and device.now >= device.since:
            return max(device.since, began) + _NOTICED + (_STALE_ONLINE if tells_link else _STALE)
        return math.inf


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
