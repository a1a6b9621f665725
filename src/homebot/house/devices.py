"""Every kind of simulated device, each from its own file. Pure: time and wire are not their business."""

from __future__ import annotations

from homebot.house.lamp import SimulatedLamp
from homebot.house.lock import SimulatedDoorLock
from homebot.house.motor import CoverMotor, WindowMotor
from homebot.house.robot import Pose, Robot
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.house.thermostat import SimulatedThermostat

__all__ = [
    "CoverMotor",
    "LuxSensor",
    "MotionSensor",
    "Pose",
    "PowerMeter",
    "Robot",
    "SimulatedContactSensor",
    "SimulatedDevice",
    "SimulatedDoorLock",
    "SimulatedLamp",
    "SimulatedThermostat",
    "WindowMotor",
]
