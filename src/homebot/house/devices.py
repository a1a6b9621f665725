"""Every kind of simulated device, each from its own file. Pure: time and wire are not their business."""

from __future__ import annotations

from homebot.house.device import Machine
from homebot.house.lamp import Lamp
from homebot.house.lock import DoorLock
from homebot.house.motor import CoverMotor, WindowMotor
from homebot.house.robot import Pose, Robot
from homebot.house.sensors import ContactSensor, LuxSensor, MotionSensor, PowerMeter
from homebot.house.thermostat import Thermostat

__all__ = [
    "ContactSensor",
    "CoverMotor",
    "DoorLock",
    "Lamp",
    "LuxSensor",
    "Machine",
    "MotionSensor",
    "Pose",
    "PowerMeter",
    "Robot",
    "Thermostat",
    "WindowMotor",
]
