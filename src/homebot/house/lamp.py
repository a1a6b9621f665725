"""A lamp: on or off, dimmed, warm or cold."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from homebot.house.simulated_device import SimulatedDevice, number, number_text

__all__ = ["SimulatedLamp"]

KELVIN = (1500.0, 9000.0)
"""From candle light to a blue sky."""


@dataclass(eq=False)
class SimulatedLamp(SimulatedDevice):
    """A lamp that does at once what it is told, and says so.

    It takes ``on``, ``off``, a brightness from ``0`` to ``1``, and a colour temperature such as ``2700 K``.

    Attributes:
        is_on: Whether it shines.
        brightness: How bright it is while on, 0 to 1.
        kelvin: Colour temperature.
        rated_watts: What it draws at full brightness, above 0: a lamp that draws nothing is dark.
        rated_lux: The light that it then gives its room.
    """

    kind: ClassVar[str] = "lamp"
    is_on: bool = False
    brightness: float = 1.0
    kelvin: float = 2700.0
    rated_watts: float = 9.0
    rated_lux: float = 150.0
    service_type: str = field(default="lights", kw_only=True)

    def state(self) -> str:
        """``on`` or ``off``."""
        return "on" if self.is_on else "off"

    def watts(self) -> float:
        """In proportion to the brightness."""
        return self.rated_watts * self.brightness if self.is_on else 0.0

    def lux(self) -> float:
        """Return the light it gives its room."""
        return self.rated_lux * self.brightness if self.is_on else 0.0

    def restore(self) -> str:
        """``on`` or ``off``."""
        return self.state()

    def commands(self) -> tuple[str, ...]:
        """Return the commands that it knows."""
        return ("on", "off", "0 to 1", f"{KELVIN[0]:g} K to {KELVIN[1]:g} K")

    def knows(self, command: str) -> bool:
        """Return whether it knows *command*."""
        if command.endswith(" K"):
            return number(command.removesuffix(" K"), *KELVIN) is not None
        return command in {"on", "off"} or number(command, 0.0, 1.0) is not None

    def _take(self, command: str) -> tuple[str, ...]:
        if command in {"on", "off"}:
            self.is_on = command == "on"
            return (command,)
        if command.endswith(" K"):
            kelvin = number(command.removesuffix(" K"), *KELVIN)
            if kelvin is None:
                return ()
            self.kelvin = kelvin
            return (f"{number_text(kelvin)} K",)
        brightness = number(command, 0.0, 1.0)
        if brightness is None:
            return ()
        self.is_on = brightness > 0
        self.brightness = brightness or self.brightness
        return (number_text(brightness),)
