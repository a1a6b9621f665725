"""The mapping between semantic types of things and properties and our vocabulary. Pure.

Source: the schemas of WebThings, https://webthings.io/schemas, used by most Thing Descriptions with semantics.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

__all__ = [
    "CAPABILITY_TYPES",
    "DEVICE_TYPE_NAMES",
    "LOCK_ACTIONS",
    "LONE_TYPES",
    "NAMES",
    "OWNED",
    "THING_TYPES",
    "UNITS",
    "WEBTHINGS",
]

WEBTHINGS: Final = "https://webthings.io/schemas"

THING_TYPES: Mapping[str, str] = {
    "Light": "light",
    "ColorControl": "light",
    "LightSwitch": "light",
    "SmartPlug": "plug",
    "Lock": "door_lock",
    "Thermostat": "thermostat",
    "DoorSensor": "contact_sensor",
    "MotionSensor": "occupancy_sensor",
    "TemperatureSensor": "temperature_sensor",
    "HumiditySensor": "humidity_sensor",
    "BarometricPressureSensor": "pressure_sensor",
    "AirQualitySensor": "air_quality_sensor",
    "LeakSensor": "water_leak_detector",
    "SmokeSensor": "smoke_co_alarm",
    "EnergyMonitor": "electrical_meter",
    "PushButton": "generic_switch",
    "Alarm": "siren",
    "Camera": "camera",
    "VideoCamera": "camera",
    "WindowCovering": "window_covering",
    "OnOffSwitch": "switch",
    "MultiLevelSwitch": "switch",
    "BinarySwitch": "switch",
}
"""The device types by semantic type of a thing; of several the first in this order counts."""

DEVICE_TYPE_NAMES: Mapping[str, str] = MappingProxyType(
    {device: name for name, device in reversed(tuple(THING_TYPES.items()))}
    | {"switch": "OnOffSwitch", "light": "Light"}
)

CAPABILITY_TYPES: Mapping[str, str] = {
    "on_off": "OnOffProperty",
    "level": "BrightnessProperty",
    "color": "ColorProperty",
    "color_temperature": "ColorTemperatureProperty",
    "position": "LevelProperty",
    "contact": "OpenProperty",
    "occupancy": "MotionProperty",
    "lock": "LockedProperty",
    "temperature": "TemperatureProperty",
    "heating_setpoint": "TargetTemperatureProperty",
    "thermostat_mode": "ThermostatModeProperty",
    "thermostat_action": "HeatingCoolingProperty",
    "humidity": "HumidityProperty",
    "pressure": "BarometricPressureProperty",
    "power": "InstantaneousPowerProperty",
    "voltage": "VoltageProperty",
    "current": "CurrentProperty",
    "frequency": "FrequencyProperty",
    "smoke": "SmokeProperty",
    "water_leak": "LeakProperty",
    "push": "PushedProperty",
}
"""The semantic type of a property for each capability that has one."""

LOCK_ACTIONS: Mapping[str, str] = {"LockAction": "locked", "UnlockAction": "unlocked"}
"""The state of a lock set by each semantic type of an action, as the property is read-only."""

OWNED: Mapping[str, frozenset[str]] = {
    "light": frozenset({"on_off", "level", "color", "color_temperature", "effect"}),
    "plug": frozenset({"on_off", "level"}),
    "switch": frozenset({"on_off", "level"}),
    "door_lock": frozenset({"lock"}),
    "window_covering": frozenset({"position", "tilt", "movement"}),
    "closure": frozenset({"position", "movement"}),
    "thermostat": frozenset(
        {
            "local_temperature",
            "heating_setpoint",
            "cooling_setpoint",
            "thermostat_mode",
            "thermostat_action",
            "preset_mode",
        }
    ),
    "fan": frozenset({"on_off", "fan_speed", "fan_mode", "oscillation", "direction"}),
    "siren": frozenset({"on_off", "volume", "siren_tone"}),
    "electrical_meter": frozenset({"power", "energy", "voltage", "current", "frequency"}),
    "robotic_vacuum_cleaner": frozenset({"vacuum", "fan_speed"}),
    "water_valve": frozenset({"valve", "position"}),
}
"""Capabilities that make up one part of a type; any other is a part by itself."""

LONE_TYPES: Mapping[str, str] = {
    "on_off": "switch",
    "level": "switch",
    "position": "window_covering",
    "movement": "window_covering",
    "lock": "door_lock",
    "alarm": "x_alarm_panel",
    "valve": "water_valve",
    "vacuum": "robotic_vacuum_cleaner",
    "fan_speed": "fan",
    "heating_setpoint": "thermostat",
    "freeze": "water_freeze_detector",
    "push": "generic_switch",
    "scene": "x_scene",
    "measurement": "x_sensor",
    "state": "x_binary_sensor",
}
"""Types of a part that has this capability and no other sign of its type; sensors have that of their capability."""

NAMES: Mapping[str, str] = {
    "on": "on_off",
    "onoff": "on_off",
    "power_state": "on_off",
    "switch": "on_off",
    "brightness": "level",
    "dimmer": "level",
    "dimmer_level": "level",
    "colour": "color",
    "colour_temperature": "color_temperature",
    "ct": "color_temperature",
    "motion": "occupancy",
    "open": "contact",
    "locked": "lock",
    "leak": "water_leak",
    "co2": "carbon_dioxide",
    "target_temperature": "heating_setpoint",
    "target_position": "position",
    "illumination": "illuminance",
    "lux": "illuminance",
    "instantaneous_power": "power",
    "battery_level": "battery",
}
"""Names of properties that mean a capability of another name."""

UNITS: Mapping[str, str] = {
    "percent": "%",
    "percentage": "%",
    "celsius": "°C",
    "degreecelsius": "°C",
    "degc": "°C",
    "cel": "°C",
    "c": "°C",
    "fahrenheit": "°F",
    "degreefahrenheit": "°F",
    "degf": "°F",
    "f": "°F",
    "kelvin": "K",
    "mired": "mired",
    "watt": "W",
    "kilowatt": "kW",
    "kilow": "kW",
    "milliwatt": "mW",
    "volt": "V",
    "millivolt": "mV",
    "ampere": "A",
    "milliampere": "mA",
    "hertz": "Hz",
    "lux": "lx",
    "hectopascal": "hPa",
    "hectopa": "hPa",
    "pascal": "Pa",
    "kilopascal": "kPa",
    "kilopa": "kPa",
    "watthour": "Wh",
    "whr": "Wh",
    "kilowatthour": "kWh",
    "kilowhr": "kWh",
}
"""Units that are spelt out, as words or in the names of QUDT and of the Ontology of units of Measure, without spaces,
hyphens and underscores."""
