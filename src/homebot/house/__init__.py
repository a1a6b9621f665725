"""The simulated house, for a first look and for tests."""

from homebot.house.devices import Lamp, SimulatedDevice, Step, WindowMotor
from homebot.house.house import SimulatedHouse, thesis_devices

__all__ = ["Lamp", "SimulatedDevice", "SimulatedHouse", "Step", "WindowMotor", "thesis_devices"]
