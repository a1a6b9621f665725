"""A thermostat and the room it heats."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from homebot.house.simulated_device import SimulatedDevice, number, number_text

__all__ = ["SimulatedThermostat"]

LEAST, MOST = 5.0, 30.0
"""Targets that it takes, in degrees Celsius."""

PERIOD = 300.0
"""Seconds between two looks at the thermometer; rooms are slow."""

BAND = 0.3
"""Kelvin below the target at which heating begins; it ends at as much above."""


@dataclass(eq=False)
class SimulatedThermostat(SimulatedDevice):
    """A thermostat in a room that cools towards the weather and, while heated, warms towards ``weather + gain``.

    First-order: the distance to where the room tends shrinks to 1/e within ``inertia`` seconds. It takes a target from
    ``5`` to ``30``, says that target, and later the room's temperature whenever it moved by 0.1 K. Degrees Celsius.
    It senses the temperature outside.

    Attributes:
        celsius: The room.
        target: What the room should be.
        outside: What it is outside.
        gain: Kelvin above outside that full heating can hold.
        inertia: Seconds.
        rated_watts: What heating draws.
    """

    kind: ClassVar[str] = "thermostat"
    celsius: float = 20.0
    target: float = 20.0
    outside: float = 10.0
    gain: float = 30.0
    inertia: float = 20_000.0
    rated_watts: float = 1000.0
    service_type: str = field(default="thermostats", kw_only=True)

    def __post_init__(self) -> None:
        self._looks_at = self.now + PERIOD
        self._reported = self.celsius
        self.heats = False

    def state(self) -> str:
        """The room's temperature as text."""
        return number_text(self.celsius, 1)

    def watts(self) -> float:
        """Its rated power while it heats."""
        return self.rated_watts if self.heats else 0.0

    def restore(self) -> str:
        """The target."""
        return number_text(self.target)

    def sense(self, value: float, now: float) -> tuple[str, ...]:
        """Let the weather be *value* degrees Celsius."""
        reports = self.advance(now)
        self.outside = value
        return reports

    def next_event(self) -> float | None:
        """Return when it looks at the thermometer."""
        return self._looks_at

    def commands(self) -> tuple[str, ...]:
        """Return the commands that it knows."""
        return (f"{LEAST:g} to {MOST:g}",)

    def knows(self, command: str) -> bool:
        """Return whether it knows *command*."""
        return number(command, LEAST, MOST) is not None

    def _take(self, command: str) -> tuple[str, ...]:
        target = number(command, LEAST, MOST)
        if target is None:
            return ()
        self.target = target
        return (number_text(target),)

    def _on_timer(self) -> tuple[str, ...]:
        self._looks_at += PERIOD
        tends_to = self.outside + (self.gain if self.heats else 0.0)
        self.celsius = tends_to + (self.celsius - tends_to) * math.exp(-PERIOD / self.inertia)
        if abs(self.celsius - self.target) > BAND:
            self.heats = self.celsius < self.target
        if abs(self.celsius - self._reported) < 0.1:
            return ()
        self._reported = self.celsius
        return (self.state(),)
