"""The mapping between semantic types of things and properties and our vocabulary. Pure.

Source: the schemas of WebThings, https://webthings.io/schemas, used by most Thing Descriptions with semantics.
"""

from collections.abc import Mapping
from typing import Final

WEBTHINGS: Final = "https://webthings.io/schemas"


def _by_word(table: Mapping[str, str]) -> dict[str, str]:
    """Return the key of each word in the values of *table*, in their order."""
    return {word: key for key, words in table.items() for word in words.split()}


THING_TYPES: Mapping[str, str] = _by_word(
    {
        "light": "Light ColorControl LightSwitch",
        "plug": "SmartPlug",
        "door_lock": "Lock",
        "x_lift": "Lift Elevator StairLift",
        "thermostat": "Thermostat",
        "contact_sensor": "DoorSensor",
        "occupancy_sensor": "MotionSensor",
        "temperature_sensor": "TemperatureSensor",
        "humidity_sensor": "HumiditySensor",
        "pressure_sensor": "BarometricPressureSensor",
        "air_quality_sensor": "AirQualitySensor",
        "water_leak_detector": "LeakSensor",
        "smoke_co_alarm": "SmokeSensor",
        "electrical_meter": "EnergyMonitor",
        "generic_switch": "PushButton",
        "siren": "Alarm",
        "camera": "Camera VideoCamera",
        "window_covering": "WindowCovering",
        "switch": "OnOffSwitch MultiLevelSwitch BinarySwitch",
    }
)
"""The device types by semantic type of a thing; of several the first in this order counts."""

DEVICE_TYPE_NAMES: Mapping[str, str] = {device: name for name, device in reversed(tuple(THING_TYPES.items()))}
"""The first semantic type of each device type."""

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
    kind: frozenset(capabilities.split())
    for kind, capabilities in {
        "light": "on_off level color color_temperature effect",
        "plug": "on_off level",
        "switch": "on_off level",
        "door_lock": "lock",
        "x_lift": "floor movement position contact session",
        "window_covering": "position tilt movement",
        "closure": "position movement",
        "thermostat": "local_temperature heating_setpoint cooling_setpoint thermostat_mode "
        "thermostat_action preset_mode",
        "fan": "on_off fan_speed fan_mode oscillation direction",
        "siren": "on_off volume siren_tone",
        "electrical_meter": "power energy voltage current frequency",
        "robotic_vacuum_cleaner": "vacuum fan_speed",
        "water_valve": "valve position",
    }.items()
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

NAMES: Mapping[str, str] = _by_word(
    {
        "on_off": "on onoff power_state switch",
        "level": "brightness dimmer dimmer_level",
        "color": "colour",
        "color_temperature": "colour_temperature ct",
        "occupancy": "motion",
        "contact": "open",
        "lock": "locked",
        "water_leak": "leak",
        "carbon_dioxide": "co2",
        "heating_setpoint": "target_temperature",
        "position": "target_position",
        "illuminance": "illumination lux",
        "power": "instantaneous_power",
        "battery": "battery_level",
    }
)
"""Names of properties that mean a capability of another name."""

UNITS: Mapping[str, str] = _by_word(
    {
        "%": "percent percentage",
        "°C": "celsius degreecelsius degc cel c",
        "°F": "fahrenheit degreefahrenheit degf f",
        "K": "kelvin",
        "mired": "mired",
        "W": "watt",
        "kW": "kilowatt kilow",
        "mW": "milliwatt",
        "V": "volt",
        "mV": "millivolt",
        "A": "ampere",
        "mA": "milliampere",
        "Hz": "hertz",
        "lx": "lux",
        "hPa": "hectopascal hectopa",
        "Pa": "pascal",
        "kPa": "kilopascal kilopa",
        "Wh": "watthour whr",
        "kWh": "kilowatthour kilowhr",
    }
)
"""Units that are spelt out, as words or in the names of QUDT and of the Ontology of units of Measure, without spaces,
hyphens and underscores."""
