"""The simulated house, for a first look and for tests."""

from homebot.house.devices import SimulatedLamp, WindowMotor
from homebot.house.house import SimulatedHouse
from homebot.house.world import World

__all__ = ["SimulatedHouse", "SimulatedLamp", "WindowMotor", "World", "thesis_world"]


def thesis_world() -> World:
    """Return the house of the thesis's experiment: two lamps, of which one is on, and a window motor."""
    return World.of(SimulatedLamp("roomlights405", is_on=True), SimulatedLamp("philips165"), WindowMotor("firstlevel1"))
