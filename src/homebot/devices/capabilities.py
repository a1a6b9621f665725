"""The capabilities of the vocabulary: Matter's clusters, each with one value in one unit.

Source: Matter 1.6 application clusters; capabilities without a Matter cluster have Home Assistant's names.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

__all__ = [
    "ALERTING",
    "CAPABILITIES",
    "EVENTS",
    "LIGHTS_UP",
    "MEASURED",
    "OWN",
    "CapabilityType",
    "Obedience",
    "ValueKind",
    "implied_settings",
    "is_told_once",
    "settable_options",
]

ValueKind: TypeAlias = Literal["bool", "number", "text", "numbers", ""]


_Words: TypeAlias = Mapping[str, frozenset[str]]
_NO_WORDS: Final[_Words] = MappingProxyType({})


class Obedience(NamedTuple):
    """The reports that prove that a command for a capability was obeyed.

    Attributes:
        tolerance: By how much a reported number may differ from the commanded one: motors stop a little off, many
            devices count percentages in 100 or 254 steps, and most thermostats half degrees.
        relative_tolerance: The tolerance as a share of the number instead; 0 for none.
        fineness: By how much two numbers may differ and be the same setting; None for half a percent.
        accepts: Further reports that confirm a commanded text.
        on_the_way: Reports that a commanded text is being carried out.
        always_sent: Commanded texts that are sent even if the device reports them already.
        moves: Whether any number means that a motor is on its way.
        zero_is_off: Whether 0 is a different state from a small number.
        rounds: Whether many devices round it to steps of several percent.
        rounds_up: Whether a device rounds it to the next higher step.
    """

    tolerance: float = 0.51
    relative_tolerance: float = 0.0
    fineness: float | None = None
    accepts: _Words = _NO_WORDS
    on_the_way: _Words = _NO_WORDS
    always_sent: frozenset[str] = frozenset()
    moves: bool = False
    zero_is_off: bool = False
    rounds: bool = False
    rounds_up: bool = False


_OBEDIENCE: Final = Obedience()


class CapabilityType(NamedTuple):
    """The meaning of all capabilities of one name.

    Attributes:
        kind: The kind of its values; empty for any.
        cluster: Number of the Matter cluster; None if Matter has none.
        unit: The unit of a number; empty if it has none, or each device names its own.
        bounds: Smallest and largest number; empty if there is none.
        options: The allowed texts; empty if each device names its own.
        is_event: Whether a value is an event, which is over at once, rather than a lasting state: each is reported
            exactly once, even if it equals the previous one.
        is_momentary: Whether setting it twice acts twice.
        is_told_once: Whether a command is sent once and by one route: the usual pulse relay of a garage door stops, and
            then opens, at a second "close" (Shelly knowledge base, "Garage door opener"); a siren starts anew.
        only_reported: Texts that no command sets.
        obedience: How reports show that a command was obeyed.
        sensor: The device type of a sensor for it; empty if there is none.
    """

    name: str
    kind: ValueKind
    meaning: str
    cluster: int | None = None
    unit: str = ""
    bounds: tuple[float, ...] = ()
    options: tuple[str, ...] = ()
    is_event: bool = False
    is_momentary: bool = False
    is_told_once: bool = False
    only_reported: frozenset[str] = frozenset()
    obedience: Obedience = _OBEDIENCE
    sensor: str = ""


def _words(words: Mapping[str, str]) -> _Words:
    """Return the space-separated words for each commanded text, split."""
    return MappingProxyType({wanted: frozenset(seen.split()) for wanted, seen in words.items()})


_PERCENT = (0.0, 100.0)
_MIREDS = 0.02
"""Whole mireds are up to 1.3 % of a cold white apart (Matter 1.6 application clusters, section 3.2.7)."""

_HALF_STEP = 0.8
"""Percent; devices with 255 or 99 steps."""

_HALF_DEGREE = 0.29
"""°C; half a degree Celsius, or one degree Fahrenheit."""

_DIMMER = Obedience(tolerance=1.5, fineness=_HALF_STEP, zero_is_off=True, rounds=True)
_VOLUME = Obedience(tolerance=1.5, fineness=_HALF_STEP, rounds=True)
_WHITE = Obedience(relative_tolerance=_MIREDS, fineness=math.inf)
_MOTOR = Obedience(tolerance=3.0, fineness=math.inf, moves=True)
_SPEED = Obedience(tolerance=5.0, fineness=5.0, zero_is_off=True, rounds_up=True)
_SETPOINT = Obedience(fineness=_HALF_DEGREE)
_HUMIDITY = Obedience(tolerance=1.0, fineness=0.51)
_OPENING = Obedience(
    accepts=_words({"stopped": "open closed"}),
    on_the_way=_words({"open": "opening", "closed": "closing"}),
    always_sent=frozenset({"stopped"}),
)
_LOCK = Obedience(
    accepts=_words({"open": "unlocked opening"}),
    on_the_way=_words({"locked": "locking", "unlocked": "unlocking", "open": "unlocking"}),
    always_sent=frozenset({"open"}),
)
_VACUUM = Obedience(
    accepts=_words({"returning": "docked", "spot": "cleaning", "idle": "paused docked"}),
    always_sent=frozenset({"spot", "idle"}),
)
_MOWER = Obedience(accepts=_words({"docked": "returning"}))
_PLAYER = Obedience(accepts=_words({"paused": "stopped"}), on_the_way=_words({"playing": "buffering"}))
_ARMED = tuple(f"armed_{one}" for one in ("home", "away", "night", "vacation", "custom_bypass"))
_ALARM = Obedience(on_the_way=_words({"disarmed": "disarming pending", **dict.fromkeys(_ARMED, "arming pending")}))

_AIR, _METER, _SMOKE = "air_quality_sensor", "electrical_meter", "smoke_co_alarm"


def _opening(name: str, meaning: str, cluster: int) -> CapabilityType:
    options = ("open", "closed", "opening", "closing", "stopped")
    passing = frozenset({"opening", "closing"})
    settable = f"{meaning}; can be set to open, closed, stopped"
    return CapabilityType(
        name, "text", settable, cluster, options=options, is_told_once=True, only_reported=passing, obedience=_OPENING
    )


_CONTROLS = (
    CapabilityType("on_off", "bool", "whether it is on", 0x0006),
    CapabilityType(
        "level", "number", "brightness or strength; 0 only when off", 0x0008, "%", _PERCENT, obedience=_DIMMER
    ),
    CapabilityType(
        "color_temperature", "number", "warm to cold white", 0x0300, "K", (1000.0, 40_000.0), obedience=_WHITE
    ),
    CapabilityType("color", "numbers", "hue in degrees, 0 to 360, and saturation in percent", 0x0300),
    CapabilityType("effect", "text", "light effect"),
    CapabilityType(
        "position",
        "number",
        "how far open it is; 0 is closed",
        0x0102,
        "%",
        _PERCENT,
        is_told_once=True,
        obedience=_MOTOR,
    ),
    CapabilityType(
        "tilt", "number", "angle of the slats; 0 is closed", 0x0102, "%", _PERCENT, is_told_once=True, obedience=_MOTOR
    ),
    _opening("movement", "state of movement", 0x0102),
    CapabilityType(
        "lock",
        "text",
        "state of the lock; can be set to locked, unlocked, or open, which also opens the latch",
        0x0101,
        options=("locked", "unlocked", "locking", "unlocking", "open", "opening", "jammed"),
        is_told_once=True,
        only_reported=frozenset({"locking", "unlocking", "opening", "jammed"}),
        obedience=_LOCK,
    ),
    CapabilityType("heating_setpoint", "number", "temperature to heat to", 0x0201, "°C", obedience=_SETPOINT),
    CapabilityType("cooling_setpoint", "number", "temperature to cool to", 0x0201, "°C", obedience=_SETPOINT),
    CapabilityType("local_temperature", "number", "temperature measured by the thermostat", 0x0201, "°C"),
    CapabilityType("thermostat_mode", "text", "operating mode: off, heat, cool, auto, …", 0x0201),
    CapabilityType("thermostat_action", "text", "current action: heating, idle, …", 0x0201),
    CapabilityType("preset_mode", "text", "preset of the device"),
    CapabilityType("swing_mode", "text", "movement of the vanes", 0x0202),
    CapabilityType("swing_horizontal_mode", "text", "movement of the vanes to the sides", 0x0202),
    CapabilityType("humidity_setpoint", "number", "target humidity", None, "%", _PERCENT, obedience=_HUMIDITY),
    CapabilityType("water_heater_mode", "text", "operating mode: off, eco, …", 0x0094),
    CapabilityType("humidifier_mode", "text", "preset of the device"),
    CapabilityType("fan_speed", "number", "speed; 0 is off", 0x0202, "%", _PERCENT, obedience=_SPEED),
    CapabilityType("fan_mode", "text", "named speed of the device", 0x0202),
    CapabilityType("oscillation", "bool", "whether it oscillates", 0x0202),
    CapabilityType("direction", "text", "direction of rotation", 0x0202, options=("forward", "reverse")),
    _opening("valve", "state of the valve", 0x0081),
    CapabilityType(
        "vacuum",
        "text",
        "activity; can be set to cleaning, paused, idle (stop), returning, spot",
        0x0061,
        options=("cleaning", "docked", "returning", "paused", "idle", "error", "spot"),
        is_told_once=True,
        obedience=_VACUUM,
    ),
    CapabilityType(
        "mower",
        "text",
        "activity; can be set to mowing, paused, docked",
        options=("mowing", "paused", "docked", "returning", "error"),
        is_told_once=True,
        obedience=_MOWER,
    ),
    CapabilityType(
        "alarm",
        "text",
        "state of the alarm; can be set to disarmed, armed_home, armed_away, …",
        is_told_once=True,
        only_reported=frozenset({"pending", "arming", "disarming"}),
        obedience=_ALARM,
    ),
    CapabilityType("siren_tone", "text", "tone of the siren", is_told_once=True),
    CapabilityType(
        "playback",
        "text",
        "activity of a player; can be set to playing, paused, stopped",
        0x0506,
        options=("playing", "paused", "stopped", "buffering"),
        only_reported=frozenset({"buffering"}),
        obedience=_PLAYER,
    ),
    CapabilityType("muted", "bool", "whether its sound is muted"),
    CapabilityType("volume", "number", "volume", 0x0008, "%", _PERCENT, obedience=_VOLUME),
)

_BUTTON = "which button was pressed and how; an event, never a state"

_EVENTS = (
    CapabilityType("press", "text", _BUTTON, 0x003B, is_event=True, sensor="generic_switch"),
    CapabilityType("push", "bool", "set to true to press this button", is_momentary=True),
    CapabilityType("scene", "bool", "set to true to activate this scene", 0x0062),
    CapabilityType("scan", "text", "which tag was read; an event", is_event=True),
    CapabilityType("locate", "bool", "set to true to make the device identify itself", 0x0003),
)

_SETTINGS = (
    CapabilityType("option", "text", "selected option", 0x0050),
    CapabilityType("number", "number", "number without a standard meaning"),
    CapabilityType("text", "text", "text without a standard meaning"),
    CapabilityType("value", "text", "reported text without a standard meaning"),
    CapabilityType("state", "bool", "reported condition without a standard meaning"),
    CapabilityType("raw", "text", "raw payload that could not be decoded"),
    CapabilityType("version", "text", "installed version", 0x0028),
    CapabilityType("latest_version", "text", "latest available version", 0x002A),
    CapabilityType("image", "text", "a picture is available; it is not transmitted on the graph"),
    CapabilityType("place", "text", "location: home, not_home or a zone"),
    CapabilityType("reachable", "bool", "whether the device can be reached", 0x0039),
)

_CONDITIONS = (
    CapabilityType("contact", "bool", "whether it is open", 0x0045, sensor="contact_sensor"),
    CapabilityType("occupancy", "bool", "whether presence or motion is detected", 0x0406, sensor="occupancy_sensor"),
    CapabilityType("smoke", "bool", "whether there is smoke", 0x005C, sensor=_SMOKE),
    CapabilityType("carbon_monoxide_alarm", "bool", "whether there is carbon monoxide", 0x005C, sensor=_SMOKE),
    CapabilityType("gas", "bool", "whether there is gas", sensor=_SMOKE),
    CapabilityType("water_leak", "bool", "whether it is wet", 0x0045, sensor="water_leak_detector"),
    CapabilityType("rain", "bool", "whether it is raining", 0x0045, sensor="rain_sensor"),
    CapabilityType("freeze", "bool", "whether freezing is detected", 0x0045),
    CapabilityType("heat", "bool", "whether it is too hot"),
    CapabilityType("tamper", "bool", "whether tampering is detected"),
    CapabilityType("vibration", "bool", "whether vibration is detected"),
    CapabilityType("sound", "bool", "whether sound is detected"),
    CapabilityType("moving", "bool", "whether it is moving"),
    CapabilityType("running", "bool", "whether it is running"),
    CapabilityType("problem", "bool", "whether it has a problem"),
    CapabilityType("safety", "bool", "whether it is unsafe"),
    CapabilityType("light_detected", "bool", "whether light is detected"),
    CapabilityType("power_detected", "bool", "whether power is detected"),
    CapabilityType("plugged_in", "bool", "whether it is plugged in"),
    CapabilityType("connectivity", "bool", "whether it is connected"),
    CapabilityType("unlocked", "bool", "whether the monitored lock is unlocked"),
    CapabilityType("battery_low", "bool", "whether its battery is low", 0x002F, sensor="x_battery"),
    CapabilityType("battery_charging", "bool", "whether its battery is charging", 0x002F),
    CapabilityType("update_available", "bool", "whether an update is available", 0x002A),
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
    CapabilityType("battery", "number", "battery charge", 0x002F, "%", _PERCENT, sensor="x_battery"),
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


def _by_name(*groups: Iterable[CapabilityType]) -> Mapping[str, CapabilityType]:
    return MappingProxyType({one.name: one for group in groups for one in group})


CAPABILITIES: Mapping[str, CapabilityType] = _by_name(_CONTROLS, _EVENTS, _SETTINGS, _CONDITIONS, _MEASUREMENTS)
"""Every capability by name. A value that fits none is a ``value``, ``measurement`` or ``state``."""

MEASURED: frozenset[str] = frozenset(one.name for one in _MEASUREMENTS)
"""Names of capabilities that sensors measure."""

OWN: Final = CapabilityType("", "", "")
"""The type of a device-specific capability, which is not in the vocabulary."""

EVENTS: frozenset[str] = frozenset(one.name for one in CAPABILITIES.values() if one.is_event)
"""Names of capabilities whose values are events."""

MOMENTARY: frozenset[str] = frozenset(one.name for one in CAPABILITIES.values() if one.is_momentary)
"""Names of capabilities for which each command acts, and which have no lasting value."""

_TOLD_ONCE: frozenset[str] = MOMENTARY | {one.name for one in CAPABILITIES.values() if one.is_told_once}

SETTABLE: frozenset[str] = frozenset(
    {
        *("on_off", "level", "position", "tilt", "movement", "lock", "valve", "alarm", "vacuum", "mower", "volume"),
        *("heating_setpoint", "cooling_setpoint", "thermostat_mode", "preset_mode", "fan_speed", "fan_mode"),
    }
)
"""Names of capabilities that people and programs set; measurements change all the time and need no reason."""

ALERTING: frozenset[str] = frozenset(
    {
        *("smoke", "heat", "carbon_monoxide_alarm", "gas", "water_leak", "tamper", "problem", "safety", "freeze"),
        *("contact", "battery", "battery_low"),
    }
)
"""Names of further capabilities that :data:`homebot.devices.alerts.ALERTS` are about."""

LIGHTS_UP: Final = frozenset({"level", "color", "color_temperature", "effect"})
"""Capabilities that turn a light on."""


def is_told_once(service_type: str, capabilities: Iterable[str]) -> bool:
    """Return whether a second sending of *capabilities* to a part of *service_type* might undo the first."""
    return service_type == "siren" or not _TOLD_ONCE.isdisjoint(capabilities)


def settable_options(capability: str, options: Iterable[str]) -> tuple[str, ...]:
    """Return the *options* of *capability* that a command may set, without those that are only reported."""
    known = CAPABILITIES.get(capability, OWN)
    return tuple([one for one in options if one not in known.only_reported])


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
