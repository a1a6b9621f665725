"""Typed handles: one class for each kind of thing in a house, with its latest values and its commands.

Each name is imported on first use, because an app uses few kinds of handles.
"""

from typing import TYPE_CHECKING

from homebot.support.lazy_names import lazy_names

if TYPE_CHECKING:
    from homebot.devices.handles.appliances import AirConditioner, LawnMower, RoboticVacuumCleaner, Thermostat
    from homebot.devices.handles.follow import FollowHandles, HandleChange
    from homebot.devices.handles.handle import Handle
    from homebot.devices.handles.handle_query import CommonFilters
    from homebot.devices.handles.opening import AlarmPanel, Closure, DoorLock, WaterValve, WindowCovering
    from homebot.devices.handles.sensors import (
        ContactSensor,
        ElectricalMeter,
        HumiditySensor,
        LightSensor,
        OccupancySensor,
        PressureSensor,
        SmokeAlarm,
        TemperatureSensor,
        WaterLeakDetector,
    )
    from homebot.devices.handles.switchable import Fan, Light, MediaPlayer, Plug, Siren, Switch

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
    "HumiditySensor",
    "LawnMower",
    "Light",
    "LightSensor",
    "MediaPlayer",
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

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.devices.handles.appliances": "AirConditioner LawnMower RoboticVacuumCleaner Thermostat",
            "homebot.devices.handles.follow": "FollowHandles HandleChange",
            "homebot.devices.handles.handle": "Handle",
            "homebot.devices.handles.handle_query": "CommonFilters",
            "homebot.devices.handles.opening": "AlarmPanel Closure DoorLock WaterValve WindowCovering",
            "homebot.devices.handles.sensors": """
                ContactSensor ElectricalMeter HumiditySensor LightSensor OccupancySensor
                PressureSensor SmokeAlarm TemperatureSensor WaterLeakDetector
                """,
            "homebot.devices.handles.switchable": "Fan Light MediaPlayer Plug Siren Switch",
        },
    )
