"""The truth of a simulated house: each command that reached a device, and who was there; no sensor is asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from homebot.house import World
from homebot.house.event_log import Event, WorldLog
from homebot.house.faults import unwrap
from homebot.house.sensors import SimulatedContactSensor

__all__ = ["GroundTruth", "TruthfulCommand", "is_off"]

_OFF: Final = frozenset({"off", "0"})


@dataclass(frozen=True, slots=True)
class TruthfulCommand:
    """A command that reached a device over its radio.

    Attributes:
        at: Seconds since the first midnight.
        device: Its name.
        kind: Its kind, such as ``lamp``.
        command: In the words of the house.
        room: Where the device is.
        awake: How many people are awake there.
        is_open: Whether a contact sensor there has been open for a second.
    """

    at: float
    device: str
    kind: str
    command: str
    room: str
    awake: int
    is_open: bool


class GroundTruth(WorldLog):
    """Takes the place of the event log of a house, and looks at people and doors when a device gets a command.

    Args:
        world: The house, before its first day.
        errands: What timers of the house do, which is no command of homebot: seconds of the day and device.
    """

    def __init__(self, world: World, errands: frozenset[tuple[float, str]] = frozenset()) -> None:
        super().__init__()
        self.commands: list[TruthfulCommand] = []
        self._world = world
        self._errands = errands
        self._opened: dict[str, float] = {}

    def add(self, event: Event) -> None:
        """Write *event* down."""
        super().add(event)
        if event.verb == "says" and event.what in {"open", "closed"}:
            self._opened.setdefault(event.who, event.at)
            if event.what == "closed":
                del self._opened[event.who]
        if event.verb == "told" and (event.at % 86_400, event.who) not in self._errands:
            self.commands.append(self._seen(event))

    def _seen(self, event: Event) -> TruthfulCommand:
        placed = self._world.devices[event.who]
        return TruthfulCommand(
            event.at,
            event.who,
            unwrap(placed.device).kind,
            event.what,
            placed.room,
            self._world.awake_in(placed.room),
            any(self._is_open(name, placed.room, event.at) for name in self._opened),
        )

    def _is_open(self, name: str, room: str, now: float) -> bool:
        placed = self._world.devices[name]
        real = unwrap(placed.device)
        is_there = placed.room == room and isinstance(real, SimulatedContactSensor) and real.is_open
        return is_there and now - self._opened[name] > 1.0


def is_off(command: TruthfulCommand) -> bool:
    """Return whether a lamp is told to be dark."""
    return command.kind == "lamp" and command.command in _OFF
