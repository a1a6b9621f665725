"""Typed handles: one class for each kind of thing in a house, with what it tells and what it can be told."""

from homebot.devices.handles.alarm_panel import AlarmPanel
from homebot.devices.handles.climate import AirConditioner, Thermostat
from homebot.devices.handles.conditions import ContactSensor, OccupancySensor, SmokeAlarm, WaterLeakDetector
from homebot.devices.handles.door_lock import DoorLock
from homebot.devices.handles.fan import Fan
from homebot.devices.handles.follow import FollowHandles, HandleChange
from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery, HandleType
from homebot.devices.handles.handles import Handles
from homebot.devices.handles.light import Light
from homebot.devices.handles.measuring import (
    ElectricalMeter,
    HumiditySensor,
    LightSensor,
    PressureSensor,
    TemperatureSensor,
)
from homebot.devices.handles.opening import Closure, WaterValve, WindowCovering
from homebot.devices.handles.robots import LawnMower, RoboticVacuumCleaner
from homebot.devices.handles.switchable import Plug, Siren, Switch

__all__ = [
    "AirConditioner",
    "AlarmPanel",
    "Closure",
    "CommonFilters",
    "ContactSensor",
    "DoorLock",
    "ElectricalMeter",
    "Fan",
    "FollowHandles",
    "Handle",
    "HandleChange",
    "HandleQuery",
    "HandleType",
    "Handles",
    "HumiditySensor",
    "LawnMower",
    "Light",
    "LightSensor",
    "OccupancySensor",
    "Plug",
    "PressureSensor",
    "RoboticVacuumCleaner",
    "Siren",
    "SmokeAlarm",
    "Switch",
    "TemperatureSensor",
    "Thermostat",
    "WaterLeakDetector",
    "WaterValve",
    "WindowCovering",
]
