"""The truth of a simulated house: each command that reached a device, and who was there; no sensor is asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from homebot.house import World
from homebot.house.devices import CoverMotor
from homebot.house.event_log import Event, WorldLog
from homebot.house.faults import unwrap
from homebot.house.sensors import SimulatedContactSensor

__all__ = ["GroundTruth", "TruthfulCommand", "annoys", "is_off", "is_on"]

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
    is_open: bool
    position: float


class GroundTruth(WorldLog):
    """Takes the place of the event log of a house, and looks at people and doors when a device gets a command.

    Args:
        world: The house, before its first day.
    """

    def __init__(self, world: World) -> None:
        super().__init__()
        self.commands: list[TruthfulCommand] = []
        self._world = world
        self._opened: dict[str, float] = {}

    def add(self, event: Event) -> None:
        """Write *event* down."""
        super().add(event)
        if event.verb == "says" and event.what in {"open", "closed"}:
            self._opened.setdefault(event.who, event.at)
            if event.what == "closed":
                del self._opened[event.who]
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
            any(self._is_open(name, placed.room, event.at) for name in self._opened),
            real.position_at(event.at) if isinstance(real, CoverMotor) else 0.0,
        )

    def _is_open(self, name: str, room: str, now: float) -> bool:
        placed = self._world.devices[name]
        real = unwrap(placed.device)
        is_there = placed.room == room and isinstance(real, SimulatedContactSensor) and real.is_open
        return is_there and now - self._opened[name] > 1.0


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
