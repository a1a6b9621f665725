"""What a simulated device is: a state machine that is told the time, and says what it has to say."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Protocol

__all__ = ["Machine", "SimulatedDevice", "Step", "number", "spoken"]

HOUR = 3600.0


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
    """A device of the thesis's layout, as the wire sees it.

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


@dataclass(eq=False)
class Machine(ABC):
    """A simulated device that lives in time. It reads no clock: time is given, in seconds, and never goes back.

    Time 0 is the midnight before the house starts.

    Attributes:
        device_id: Its name.
        service_type: What it offers.
        now: The time it was last told.
    """

    device_id: str
    service_type: str = field(default="", kw_only=True)
    now: float = field(default=0.0, init=False)

    @abstractmethod
    def state(self) -> str:
        """Return what it says of itself when nobody asks."""

    def obey(self, command: str, now: float | None = None) -> tuple[Step, ...]:
        """Take *command*.

        Args:
            command: A word, or a number as text; what it does not know it ignores.
            now: The time. Without it the device is played forward, for at most an hour, and its steps tell when.

        Returns:
            What it says at once, with the reports that were due before; what comes later comes from :meth:`advance`.
        """
        if now is None:
            return self._played(command)
        return tuple(Step(0.0, report) for report in (*self.advance(now), *self._take(command)))

    def advance(self, now: float) -> tuple[str, ...]:
        """Let time pass until *now* and return the reports due on the way, oldest first."""
        reports: list[str] = []
        while (at := self.next_event()) is not None and at <= now:
            self.now = max(self.now, at)
            reports += self._happen()
        self.now = max(self.now, now)
        return tuple(reports)

    def next_event(self) -> float | None:
        """Return when it will next do something by itself, or None while it rests."""
        return None

    def sense(self, value: float, now: float) -> tuple[str, ...]:
        """Let the world act on it with *value*, whose meaning is the device's own; return what it says.

        Most devices feel nothing.
        """
        del value
        return self.advance(now)

    def by_hand(self, command: str, now: float) -> tuple[str, ...]:
        """Let somebody work it with their hands, as *command* would; return what it says at once."""
        return tuple(step.report for step in self.obey(command, now))

    def watts(self) -> float:
        """Return the power it draws, in watts."""
        return 0.0

    def restore(self) -> str:
        """Return the command that would bring it back to how it is now; empty when there is none."""
        return ""

    def _take(self, command: str) -> tuple[str, ...]:
        """Obey at :attr:`now`; return what it says at once."""
        del command
        return ()

    def _happen(self) -> tuple[str, ...]:
        """Do what :meth:`next_event` announced; must move that on."""
        return ()

    def _played(self, command: str) -> tuple[Step, ...]:
        end = self.now + HOUR
        steps = [Step(0.0, report) for report in self._take(command)]
        spoken_at = self.now
        while (at := self.next_event()) is not None and at <= end:
            for report in self.advance(at):
                steps.append(Step(self.now - spoken_at, report))
                spoken_at = self.now
        return tuple(steps)


def number(text: str, low: float, high: float) -> float | None:
    """Return the number that *text* spells, or None when it spells none from *low* to *high*."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and low <= value <= high else None


def spoken(value: float, digits: int = 3) -> str:
    """Return *value* as devices say it: decimal text with at most *digits* decimals."""
    return f"{round(value, digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{round(value)}"
