"""The simulated house, for a first look and for tests."""

from homebot.house.devices import SimulatedLamp, WindowMotor
from homebot.house.house import SimulatedHouse
from homebot.house.thesis import thesis_world
from homebot.house.world import World

__all__ = ["SimulatedHouse", "SimulatedLamp", "WindowMotor", "World", "thesis_world"]
