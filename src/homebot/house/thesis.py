"""The house of the thesis."""

from __future__ import annotations

from homebot.house.lamp import SimulatedLamp
from homebot.house.motor import WindowMotor
from homebot.house.world import World

__all__ = ["thesis_world"]


def thesis_world() -> World:
    """Return the house of the thesis's experiment: two lamps, of which one is on, and a window motor."""
    return World.of(SimulatedLamp("roomlights405", is_on=True), SimulatedLamp("philips165"), WindowMotor("firstlevel1"))
