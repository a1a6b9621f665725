"""Simulated devices: what they are and how they take a command. Pure; time and wire are the house's business."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

__all__ = ["Lamp", "SimulatedDevice", "Step", "WindowMotor"]


@dataclass(frozen=True, slots=True)
class Step:
    """One thing a device says while it obeys.

    Attributes:
        after: Seconds that pass before.
        report: What it then says of itself.
    """

    after: float
    report: str


class SimulatedDevice(Protocol):
    """A device of the thesis's layout.

    Attributes:
        service_type: What it offers.
        device_id: Its name.
    """

    service_type: str
    device_id: str

    def state(self) -> str:
        """Return what it says of itself when nobody asks."""
        ...

    def obey(self, command: str) -> tuple[Step, ...]:
        """Take *command* and return what it says on the way; nothing when it does not know the command."""
        ...


@dataclass(slots=True)
class Lamp:
    """A lamp that can be ``on`` or ``off``, and says so at once."""

    device_id: str
    is_on: bool = False
    service_type: str = "lights"

    def state(self) -> str:
        """``on`` or ``off``."""
        return "on" if self.is_on else "off"

    def obey(self, command: str) -> tuple[Step, ...]:
        """Switch ``on`` or ``off``."""
        if command not in {"on", "off"}:
            return ()
        self.is_on = command == "on"
        return (Step(0.0, command),)


@dataclass(slots=True)
class WindowMotor:
    """A motor that takes a while to ``open`` or ``close`` its window.

    Attributes:
        travel_time: Seconds from one end to the other.
    """

    device_id: str
    is_open: bool = False
    travel_time: float = 3.0
    service_type: str = "windows"

    def state(self) -> str:
        """``open`` or ``closed``."""
        return "open" if self.is_open else "closed"

    def obey(self, command: str) -> tuple[Step, ...]:
        """``open`` or ``close``; says ``opening`` or ``closing``, then where it arrived."""
        if command not in {"open", "close"}:
            return ()
        self.is_open = command == "open"
        moving = "opening" if self.is_open else "closing"
        return (Step(0.0, moving), Step(self.travel_time, self.state()))
