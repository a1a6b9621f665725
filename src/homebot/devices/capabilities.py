"""The capabilities of the vocabulary: Matter's clusters, each with one value in one unit.

Source: Matter 1.6 application clusters; capabilities without a Matter cluster have Home Assistant's names.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from homebot.devices.capability_type import (
    ALARM,
    DIMMER,
    HUMIDITY,
    LOCK,
    MOTOR,
    MOWER,
    OPENING,
    PLAYER,
    SETPOINT,
    SPEED,
    VACUUM,
    VOLUME,
    WHITE,
    CapabilityType,
)

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

_PERCENT = (0.0, 100.0)
_ENDS: Final = {"open": 100.0, "close": 0.0}
_PRESS: Final = {"press": True}
_SHUT: Final = ("closed", "open")
_AIR, _METER, _SMOKE = "air_quality_sensor", "electrical_meter", "smoke_co_alarm"


_share = partial(CapabilityType, kind="number", unit="%", bounds=_PERCENT, is_set=True, bare="share")
"""A percentage that people set; 0 to 1 in texts."""


def _opening(name: str, meaning: str, cluster: int) -> CapabilityType:
    options = ("open", "closed", "opening", "closing", "stopped")
    passing = frozenset({"opening", "closing"})
    return CapabilityType(
        name,
        "text",
        f"{meaning}; can be set to open, closed, stopped",
        cluster,
        options=options,
        is_told_once=True,
        only_reported=passing,
        comparison=OPENING,
        is_set=True,
        words={"open": "open", "close": "closed", "stop": "stopped"},
    )


_CONTROLS = (
    CapabilityType(
        "on_off", "bool", "whether it is on", 0x0006, is_set=True, flags=("off", "on"), words={"on": True, "off": False}
    ),
    _share(
        "level",
        meaning="brightness or strength; 0 only when off",
        cluster=0x0008,
        comparison=DIMMER,
        lights_up=True,
        spoken="brightness",
    ),
    CapabilityType(
        "color_temperature",
        "number",
        "warm to cold white",
        0x0300,
        "K",
        (1000.0, 40_000.0),
        comparison=WHITE,
        lights_up=True,
        spoken="kelvin",
    ),
    CapabilityType("color", "numbers", "hue in degrees, 0 to 360, and saturation in percent", 0x0300, lights_up=True),
    CapabilityType("effect", "text", "light effect", lights_up=True),
    _opening("movement", "state of movement", 0x0102),
    _opening("valve", "state of the valve", 0x0081),
    _share(
        "position",
        meaning="how far open it is; 0 is closed",
        cluster=0x0102,
        comparison=MOTOR,
        is_told_once=True,
        words=_ENDS,
    ),
    _share(
        "tilt",
        meaning="angle of the slats; 0 is closed",
        cluster=0x0102,
        comparison=MOTOR,
        is_told_once=True,
        words=_ENDS,
    ),
    CapabilityType(
        "lock",
        "text",
        "state of the lock; can be set to locked, unlocked, or open, which also opens the latch",
        0x0101,
        options=("locked", "unlocked", "locking", "unlocking", "open", "opening", "jammed"),
        is_told_once=True,
        only_reported=frozenset({"locking", "unlocking", "opening", "jammed"}),
        comparison=LOCK,
        is_set=True,
        words={"open": "open", "lock": "locked", "unlock": "unlocked"},
        by_state=True,
    ),
    _share("fan_speed", meaning="speed; 0 is off", cluster=0x0202, comparison=SPEED, spoken="speed"),
    CapabilityType(
        "heating_setpoint",
        "number",
        "temperature to heat to",
        0x0201,
        "°C",
        comparison=SETPOINT,
        is_set=True,
        bare="number",
    ),
    CapabilityType(
        "cooling_setpoint",
        "number",
        "temperature to cool to",
        0x0201,
        "°C",
        comparison=SETPOINT,
        is_set=True,
        bare="number",
    ),
    CapabilityType("local_temperature", "number", "temperature measured by the thermostat", 0x0201, "°C"),
    CapabilityType(
        "thermostat_mode",
        "text",
        "operating mode: off, heat, cool, auto, …",
        0x0201,
        is_set=True,
        spoken="mode",
        by_state=True,
    ),
    CapabilityType("thermostat_action", "text", "current action: heating, idle, …", 0x0201),
    CapabilityType("preset_mode", "text", "preset of the device", is_set=True),
    CapabilityType("swing_mode", "text", "movement of the vanes", 0x0202),
    CapabilityType("swing_horizontal_mode", "text", "movement of the vanes to the sides", 0x0202),
    CapabilityType("fan_mode", "text", "named speed of the device", 0x0202, is_set=True, spoken="mode"),
    CapabilityType("oscillation", "bool", "whether it oscillates", 0x0202),
    CapabilityType("direction", "text", "direction of rotation", 0x0202, options=("forward", "reverse")),
    CapabilityType(
        "humidity_setpoint", "number", "target humidity", None, "%", _PERCENT, comparison=HUMIDITY, bare="number"
    ),
    CapabilityType("humidifier_mode", "text", "preset of the device", spoken="mode"),
    CapabilityType("water_heater_mode", "text", "operating mode: off, eco, …", 0x0094, spoken="mode"),
    CapabilityType(
        "vacuum",
        "text",
        "activity; can be set to cleaning, paused, idle (stop), returning, spot",
        0x0061,
        options=("cleaning", "docked", "returning", "paused", "idle", "error", "spot"),
        is_told_once=True,
        comparison=VACUUM,
        is_set=True,
        by_state=True,
    ),
    CapabilityType(
        "clean_rooms",
        "text",
        "set to the rooms of its map to clean, by name or number, with commas between them",
        0x0150,
        is_told_once=True,
    ),
    CapabilityType(
        "mower",
        "text",
        "activity; can be set to mowing, paused, docked",
        options=("mowing", "paused", "docked", "returning", "error"),
        is_told_once=True,
        comparison=MOWER,
        is_set=True,
        by_state=True,
    ),
    CapabilityType(
        "floor",
        "text",
        "floor where a lift is; set to the one where it is wanted",
        is_told_once=True,
        is_set=True,
        by_state=True,
    ),
    CapabilityType(
        "alarm",
        "text",
        "state of the alarm; can be set to disarmed, armed_home, armed_away, …",
        is_told_once=True,
        only_reported=frozenset({"pending", "arming", "disarming"}),
        comparison=ALARM,
        is_set=True,
        by_state=True,
    ),
    CapabilityType("siren_tone", "text", "tone of the siren", is_told_once=True),
    CapabilityType(
        "playback",
        "text",
        "activity of a player; can be set to playing, paused, stopped",
        0x0506,
        options=("playing", "paused", "stopped", "buffering"),
        only_reported=frozenset({"buffering"}),
        comparison=PLAYER,
        words={"stop": "stopped", "play": "playing", "pause": "paused"},
    ),
    CapabilityType("media_title", "text", "title of what a player plays"),
    CapabilityType("media_artist", "text", "who plays or speaks what a player plays"),
    CapabilityType("media", "text", "set to the address that a player plays", is_told_once=True),
    CapabilityType(
        "muted",
        "bool",
        "whether its sound is muted",
        flags=("not muted", "muted"),
        words={"mute": True, "unmute": False},
    ),
    _share("volume", meaning="volume", cluster=0x0008, comparison=VOLUME),
)

_BUTTON = "which button was pressed and how; an event, never a state"

_EVENTS = (
    CapabilityType("press", "text", _BUTTON, 0x003B, is_event=True, sensor="generic_switch"),
    CapabilityType("push", "bool", "set to true to press this button", is_momentary=True, words=_PRESS),
    CapabilityType("scene", "bool", "set to true to activate this scene", 0x0062, words=_PRESS),
    CapabilityType("scan", "text", "which tag was read; an event", is_event=True),
    CapabilityType("locate", "bool", "set to true to make the device identify itself", 0x0003, words=_PRESS),
)

_SETTINGS = (
    CapabilityType("option", "text", "selected option", 0x0050),
    CapabilityType("number", "number", "number without a standard meaning", bare="number"),
    CapabilityType("text", "text", "text without a standard meaning"),
    CapabilityType("value", "text", "reported text without a standard meaning"),
    CapabilityType("state", "bool", "reported condition without a standard meaning", flags=("off", "on")),
    CapabilityType("raw", "text", "raw payload that could not be decoded"),
    CapabilityType("version", "text", "installed version", 0x0028),
    CapabilityType("latest_version", "text", "latest available version", 0x002A),
    CapabilityType("update_progress", "number", "how far the installation of an update is", 0x002A, "%", _PERCENT),
    CapabilityType("image", "text", "a picture is available; it is not transmitted on the graph"),
    CapabilityType("place", "text", "location: home, not_home or a zone"),
    CapabilityType("session", "text", "who has a lift, such as a robot; empty for nobody"),
    CapabilityType("reachable", "bool", "whether the device can be reached", 0x0039),
)

_CONDITIONS = (
    CapabilityType(
        "contact",
        "bool",
        "whether it is open",
        0x0045,
        sensor="contact_sensor",
        is_alerting=True,
        flags=_SHUT,
        texts=_SHUT,
    ),
    CapabilityType(
        "occupancy",
        "bool",
        "whether presence or motion is detected",
        0x0406,
        sensor="occupancy_sensor",
        flags=("clear", "occupied"),
        texts=("clear", "motion"),
    ),
    CapabilityType("smoke", "bool", "whether there is smoke", 0x005C, sensor=_SMOKE, is_alerting=True),
    CapabilityType(
        "carbon_monoxide_alarm", "bool", "whether there is carbon monoxide", 0x005C, sensor=_SMOKE, is_alerting=True
    ),
    CapabilityType("gas", "bool", "whether there is gas", sensor=_SMOKE, is_alerting=True),
    CapabilityType(
        "water_leak",
        "bool",
        "whether it is wet",
        0x0045,
        sensor="water_leak_detector",
        is_alerting=True,
        flags=("dry", "wet"),
    ),
    CapabilityType("rain", "bool", "whether it is raining", 0x0045, sensor="rain_sensor"),
    CapabilityType("freeze", "bool", "whether freezing is detected", 0x0045, is_alerting=True),
    CapabilityType("heat", "bool", "whether it is too hot", is_alerting=True),
    CapabilityType("tamper", "bool", "whether tampering is detected", is_alerting=True),
    CapabilityType("vibration", "bool", "whether vibration is detected"),
    CapabilityType("sound", "bool", "whether sound is detected"),
    CapabilityType(
        "at_home", "bool", "whether the person, or one of the household, is at home", flags=("away", "at home")
    ),
    CapabilityType(
        "all_at_home",
        "bool",
        "whether everybody of the household is at home",
        flags=("somebody away", "everybody at home"),
    ),
    CapabilityType("moving", "bool", "whether it is moving", flags=("still", "moving")),
    CapabilityType("running", "bool", "whether it is running", flags=("idle", "running")),
    CapabilityType("problem", "bool", "whether it has a problem", is_alerting=True),
    CapabilityType("safety", "bool", "whether it is unsafe", is_alerting=True, flags=("safe", "unsafe")),
    CapabilityType("light_detected", "bool", "whether light is detected"),
    CapabilityType("power_detected", "bool", "whether power is detected"),
    CapabilityType("plugged_in", "bool", "whether it is plugged in", flags=("unplugged", "plugged in")),
    CapabilityType("connectivity", "bool", "whether it is connected", flags=("disconnected", "connected")),
    CapabilityType("unlocked", "bool", "whether the monitored lock is unlocked", flags=("locked", "unlocked")),
    CapabilityType(
        "battery_low",
        "bool",
        "whether its battery is low",
        0x002F,
        sensor="x_battery",
        is_alerting=True,
        flags=("battery good", "battery low"),
    ),
    CapabilityType(
        "battery_charging", "bool", "whether its battery is charging", 0x002F, flags=("not charging", "charging")
    ),
    CapabilityType(
        "update_available", "bool", "whether an update is available", 0x002A, flags=("up to date", "update available")
    ),
)

_MEASUREMENTS = (
    CapabilityType("temperature", "number", "temperature", 0x0402, "°C", sensor="temperature_sensor"),
    CapabilityType("humidity", "number", "relative humidity", 0x0405, "%", _PERCENT, sensor="humidity_sensor"),
    CapabilityType("illuminance", "number", "illuminance", 0x0400, "lx", sensor="light_sensor"),
    CapabilityType("pressure", "number", "air pressure", 0x0403, "hPa", sensor="pressure_sensor"),
    CapabilityType("flow", "number", "flow", 0x0404, "m³/h", sensor="flow_sensor"),
    CapabilityType("power", "number", "electrical power consumption", 0x0090, "W", sensor=_METER),
    CapabilityType("energy", "number", "electrical energy consumption", 0x0091, "kWh", sensor=_METER),
    CapabilityType("energy_returned", "number", "electrical energy returned to the grid", 0x0091, "kWh", sensor=_METER),
    CapabilityType("voltage", "number", "voltage", 0x0090, "V", sensor=_METER),
    CapabilityType("current", "number", "current", 0x0090, "A", sensor=_METER),
    CapabilityType("frequency", "number", "frequency", 0x0090, "Hz", sensor=_METER),
    CapabilityType("battery", "number", "battery charge", 0x002F, "%", _PERCENT, sensor="x_battery", is_alerting=True),
    CapabilityType("carbon_dioxide", "number", "carbon dioxide", 0x040D, "ppm", sensor=_AIR),
    CapabilityType("carbon_monoxide", "number", "carbon monoxide", 0x040C, "ppm", sensor=_AIR),
    CapabilityType("pm25", "number", "particulate matter (PM2.5)", 0x042A, "µg/m³", sensor=_AIR),
    CapabilityType("pm10", "number", "particulate matter (PM10)", 0x042D, "µg/m³", sensor=_AIR),
    CapabilityType("pm1", "number", "particulate matter (PM1)", 0x042C, "µg/m³", sensor=_AIR),
    CapabilityType("volatile_organic_compounds", "number", "volatile organic compounds", 0x042E, "µg/m³", sensor=_AIR),
    CapabilityType("air_quality_index", "number", "air quality", 0x005B, sensor=_AIR),
    CapabilityType("soil_moisture", "number", "soil moisture", 0x0430, "%", _PERCENT, sensor="soil_sensor"),
    CapabilityType("signal_strength", "number", "radio signal strength", 0x0036, "dBm"),
    CapabilityType("measurement", "number", "measured number without a standard meaning"),
)


def _by_name(*groups: tuple[CapabilityType, ...]) -> Mapping[str, CapabilityType]:
    rows = {row.name: row for group in groups for row in group}
    assert len(rows) == sum(map(len, groups)), "a capability has two rows"  # noqa: S101 - for who adds one
    return MappingProxyType(rows)


CAPABILITIES: Mapping[str, CapabilityType] = _by_name(_CONTROLS, _EVENTS, _SETTINGS, _CONDITIONS, _MEASUREMENTS)
"""Every capability by name; of those that the same word or number sets, a part takes the first.

A value that fits none is a ``value``, ``measurement`` or ``state``.
"""

MEASURED: frozenset[str] = frozenset(measurement.name for measurement in _MEASUREMENTS)
"""Names of capabilities that sensors measure."""

OWN: Final = CapabilityType("", "", "")
"""The type of a device-specific capability, which is not in the vocabulary."""

EVENTS: frozenset[str] = frozenset(capability.name for capability in CAPABILITIES.values() if capability.is_event)
"""Names of capabilities with events as values."""

MOMENTARY: frozenset[str] = frozenset(
    capability.name for capability in CAPABILITIES.values() if capability.is_momentary
)
"""Names of capabilities for which each command acts, and which have no lasting value."""

_TOLD_ONCE: frozenset[str] = MOMENTARY | {
    capability.name for capability in CAPABILITIES.values() if capability.is_told_once
}

SETTABLE: frozenset[str] = frozenset(capability.name for capability in CAPABILITIES.values() if capability.is_set)
"""Names of capabilities that people and programs set."""

ALERTING: frozenset[str] = frozenset(capability.name for capability in CAPABILITIES.values() if capability.is_alerting)
"""Names of further capabilities that alerts are about."""

DANGERS: frozenset[str] = ALERTING - {"battery", "battery_low", "contact"}
"""Those that are true in a danger, such as smoke."""

LIGHTS_UP: frozenset[str] = frozenset(capability.name for capability in CAPABILITIES.values() if capability.lights_up)
"""Names of capabilities that turn a light on."""

SPEED_WORDS: frozenset[str] = frozenset(
    capability.name for capability in CAPABILITIES.values() if capability.comparison.zero_is_off
)
"""Names of capabilities that are 0 only when off."""


def is_told_once(service_type: str, capabilities: Iterable[str]) -> bool:
    """Return whether a second sending of *capabilities* to a part of *service_type* might undo the first."""
    return service_type == "siren" or not _TOLD_ONCE.isdisjoint(capabilities)


def acts_each_time(settings: Mapping[str, PlainValue]) -> bool:
    """Return whether *settings* have a stop, a press, or the latch of an unlocked door, which act whenever sent."""
    return any(
        name in MOMENTARY or value in CAPABILITIES.get(name, OWN).comparison.always_sent
        for name, value in settings.items()
    )


def settable_options(capability: str, options: Iterable[str]) -> tuple[str, ...]:
    """Return the *options* of *capability* that a command may set, without those that are only reported."""
    known = CAPABILITIES.get(capability, OWN)
    return tuple([option for option in options if option not in known.only_reported])


def implied_settings(
    capability: str, value: PlainValue, settable: Container[str]
) -> tuple[tuple[str, PlainValue], ...]:
    """Return the ordered settings that set *capability* to *value* and turn a light on, or off at level 0.

    Gateways call it for protocols in which setting the brightness or colour of a light that is off leaves it off.

    Args:
        settable: The capabilities that the part takes.
    """
    if capability not in LIGHTS_UP or "on_off" not in settable:
        return ((capability, value),)
    if capability == "level" and value == 0:
        return (("on_off", False),)
    return ((capability, value), ("on_off", True))
