"""Types of nodes, quantities and conditions, by units and by words. Tables, pure.

A guess needs both: words that suggest it and a form that fits. A qualifier beside them contradicts it: a child
lock locks no door, a water tank does not leak.

Source: hc-smarthome v2 and v1 (homie-homecontrol/hc-homie5-smarthome); homie5-device-profiles, draft; Homie
convention 5, Units.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.units import measured_in
from homebot.integrations.homie.formats.model import HomieNode

__all__ = [
    "KINDS",
    "Kind",
    "condition_of",
    "declared_class",
    "declared_kind",
    "guessed_kinds",
    "is_beside",
    "is_setting",
    "quantity_of",
    "tokens_in",
]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of node.

    Attributes:
        service_type: The service type of its controls; empty if it has none.
        condition: The capability of its first reported boolean, with any id.
    """

    service_type: str = ""
    roles: Mapping[str, str] = field(default_factory=dict)
    condition: str = ""
    tag: str = ""


_SWITCH = {"state": "on_off"}
_LEVEL = {"value": "level", "brightness": "level"}
_COLOR = {"color": "color", "color-temperature": "color_temperature"}

KINDS: Mapping[str, Kind] = {
    "switch": Kind("switch", _SWITCH),
    "level": Kind("light", _LEVEL),
    "dimmer": Kind("light", _LEVEL),
    "color": Kind("light", _COLOR),
    "colorlight": Kind("light", _COLOR),
    "light": Kind("light", {**_SWITCH, "brightness": "level", **_COLOR}),
    "shutter": Kind("window_covering", {"position": "position", "tilt": "tilt", "action": "move"}, tag="shutter"),
    "garage-door": Kind("closure", {"state": "movement", "action": "move"}, tag="garage"),
    "lock": Kind("door_lock", {"state": "lock", "action": "lock_action"}),
    "valve": Kind("water_valve", {"state": "valve"}),
    "thermostat": Kind(
        "thermostat",
        {"set-temperature": "heating_setpoint", "mode": "thermostat_mode", "temperature": "local_temperature"},
    ),
    "fan": Kind("fan", {"speed": "fan_mode", "state": "on_off"}),
    "motion": Kind(condition="occupancy"),
    "contact": Kind(condition="contact"),
    "water": Kind(condition="water_leak"),
    "smoke": Kind(condition="smoke"),
    "co": Kind(condition="carbon_monoxide_alarm"),
    "vibration": Kind(condition="vibration"),
    "tilt": Kind(condition="state"),
    "battery": Kind(roles={"battery-level": "battery", "low-battery": "battery_low"}),
    "maintenance": Kind(roles={"battery-level": "battery", "low-battery": "battery_low"}),
    "button": Kind(roles={"action": "press"}),
    **{name: Kind() for name in ("climate", "weather", "illuminance", "powermeter", "air-quality", "numeric", "scene")},
}
"""Kinds by the name at the end of a node's type."""

_DECLARED = re.compile(
    r"(?:hc-smarthome/v[0-9]+/cap/|(?:homie-homecontrol|hc-smarthome|homie-capability-profile)/v[0-9]+/type=)"
    r"([a-z0-9-]{1,40})"
)
_CLASS = re.compile(r"(?:hc-smarthome/v[0-9]+/dc/|homie-device-profile/v[0-9]+/type=)([a-z0-9-]{1,40})")

_GUESSES: tuple[tuple[str, frozenset[str]], ...] = (
    ("garage-door", frozenset({"garage", "gate", "gates"})),
    ("shutter", frozenset({"shutter", "blind", "blinds", "cover", "curtain", "roller", "awning", "shade"})),
    ("lock", frozenset({"lock"})),
    ("thermostat", frozenset({"thermostat", "heater", "heating", "radiator", "setpoint", "heatsetpoint"})),
    ("fan", frozenset({"fan", "ventilator"})),
    ("valve", frozenset({"valve"})),
    ("light", frozenset({"light", "lights", "lamp", "bulb", "led", "dimmer", "strip", "rgb", "luminaire", "lighting"})),
)
_TOKEN = re.compile(r"[a-z]+[0-9]*")
_LONGEST = 200


def declared_kind(node_type: str) -> str:
    """Return the name of the declared kind of *node_type*; empty if it is unknown."""
    match = _DECLARED.fullmatch(node_type)
    return match[1] if match is not None and match[1] in KINDS else ""


def declared_class(device_type: str) -> str:
    """Return the declared class of a device, such as ``light`` or ``outlet``; empty for none."""
    match = _CLASS.fullmatch(device_type)
    return match[1] if match is not None else ""


def guessed_kinds(node: HomieNode, around: frozenset[str]) -> tuple[str, ...]:
    """Return the kinds suggested by the words of *node*, then those suggested by the words *around* it."""
    own = tokens_in(node.type, node.id, node.name, *(prop.id for prop in node.properties))
    if own & _CHARGERS:
        return ()
    left_out = "lock" if around & _CHARGERS else ""
    found = (kind for tokens in (own, around) for kind, hints in _GUESSES if tokens & hints and kind != left_out)
    return tuple(dict.fromkeys(found))


_CHARGERS = frozenset({"charger", "ev", "evse"})
"""Words of nodes and devices that charge a car, whose lock is that of the plug."""


def tokens_in(*texts: str) -> frozenset[str]:
    """Return the words of *texts* in small letters."""
    return frozenset(token for text in texts for token in _TOKEN.findall(text[:_LONGEST].casefold()))


_BESIDE = frozenset(
    {"alarm", "auto", "automatic", "away", "backlight", "beep", "behavior", "behaviour", "boost", "button"}
    | {"buzzer", "calibration", "child", "comfort", "correction", "day", "default", "delay", "delta", "detection"}
    | {"difference", "display", "duration", "eco", "enable", "enabled", "firmware", "frost", "holiday", "humidity"}
    | {"hysteresis", "identify", "indicator", "interval", "key", "keypad", "keys", "limit", "lockout", "max"}
    | {"maximum", "memory", "min", "minimum", "mute", "night", "offset", "panel", "protection", "ramp", "rate"}
    | {"reset", "restart", "runtime", "schedule", "screen", "sensitivity", "sound", "speaker", "standby", "startup"}
    | {"status", "threshold", "time", "timeout", "timer", "tone", "transition", "travel", "update", "vibration"}
    | {"volume", "water"}
)
"""Words of properties that are settings, or do not serve the purpose of their node."""

_SETTINGS = frozenset(
    {"backlight", "calibration", "child", "display", "firmware", "hysteresis", "identify", "indicator", "keypad"}
    | {"keys", "lockout", "offset", "reset", "schedule", "screen", "sensitivity", "threshold", "update"}
)
"""Words of nodes for configuration."""

_OBJECTS = frozenset(
    {"attached", "bell", "boiler", "box", "button", "connected", "dock", "empty", "enabled", "filter", "full"}
    | {"grade", "heater", "heating", "hot", "installed", "level", "light", "lock", "locked", "low", "meter", "mode"}
    | {"mop", "opener", "pump", "supply", "tank", "temperature", "usage", "valve", "watertank"}
)
"""Things that have water, gas or a door as a part, not as a condition."""


def is_beside(tokens: frozenset[str]) -> bool:
    """Return whether a property with these words does not serve the purpose of its node."""
    return not tokens.isdisjoint(_BESIDE)


def _is_object(tokens: frozenset[str]) -> bool:
    """Return whether the words of a property name a thing, so that a condition is only part of its name."""
    return not tokens.isdisjoint(_OBJECTS)


def is_setting(tokens: frozenset[str]) -> bool:
    """Return whether a node with these words is for configuration."""
    return not tokens.isdisjoint(_SETTINGS)


_BY_TOKEN: tuple[tuple[str, str, frozenset[str]], ...] = (
    ("battery", "battery", frozenset({"", "%"})),
    ("soc", "battery", frozenset({"%"})),
    ("humidity", "humidity", frozenset({"", "%"})),
    ("moisture", "soil_moisture", frozenset({"%"})),
    ("temperature", "temperature", frozenset({""})),
    ("illuminance", "illuminance", frozenset({""})),
    ("lux", "illuminance", frozenset({""})),
    ("pressure", "pressure", frozenset({""})),
    ("co2", "carbon_dioxide", frozenset({"", "ppm"})),
    ("dioxide", "carbon_dioxide", frozenset({"", "ppm"})),
    ("monoxide", "carbon_monoxide", frozenset({"", "ppm"})),
    ("co", "carbon_monoxide", frozenset({"ppm"})),
    ("pm25", "pm25", frozenset({"", "µg/m³"})),
    ("pm2", "pm25", frozenset({"µg/m³"})),
    ("pm10", "pm10", frozenset({"", "µg/m³"})),
    ("voc", "volatile_organic_compounds", frozenset({"µg/m³"})),
    ("rssi", "signal_strength", frozenset({""})),
)

_NO_MEASURE = frozenset({"color", "colour", "count", "cycles", "health", "time"})
"""Words that change the meaning of others: the temperature of a colour, the cycles of a battery."""

_RATINGS = frozenset({"advertised", "limit", "maximum", "nameplate", "nominal", "rated", "rating", "soe"})
"""Words of what a thing is made for, allowed or holds, not of what is measured: a breaker of 200 A."""

_RETURNED = frozenset({"export", "exported", "returned"})

_SHORT = 4
"""Longer words also count as the beginning of another, as ``battery`` in ``batterystate``."""

_CONDITION_TOKENS: Mapping[str, tuple[str, ...]] = {
    "occupancy": ("motion", "occupancy", "presence"),
    "contact": ("contact", "door", "window", "open"),
    "water_leak": ("water", "leak", "flood"),
    "smoke": ("smoke",),
    "carbon_monoxide_alarm": ("co",),
    "gas": ("gas",),
    "vibration": ("vibration",),
    "tamper": ("tamper", "sabotage"),
    "rain": ("rain",),
}
_CONDITIONS: Mapping[str, str] = {one: capability for capability, names in _CONDITION_TOKENS.items() for one in names}
"""Capabilities of boolean properties, by a token of their name."""


def quantity_of(unit: str, tokens: frozenset[str]) -> tuple[str, bool]:
    """Return the capability of a number by its unit and its words, and whether that is a guess."""
    unit = unit.strip()
    if not tokens.isdisjoint(_RATINGS):
        return "measurement", False
    if unit == "dBm":
        return "signal_strength", False
    if found := measured_in(unit):
        return _directed(found, tokens), False
    if not tokens.isdisjoint(_NO_MEASURE):
        return "measurement", False
    for token, capability, units in _BY_TOKEN:
        if unit in units and _contains(tokens, token):
            return capability, True
    return "measurement", False


def _contains(tokens: frozenset[str], token: str) -> bool:
    return any(one.startswith(token) if len(token) > _SHORT else one == token for one in tokens)


def _directed(capability: str, tokens: frozenset[str]) -> str:
    return "energy_returned" if capability == "energy" and tokens & _RETURNED else capability


def condition_of(tokens: frozenset[str], around: frozenset[str]) -> str:
    """Return the capability of a boolean; ``state`` if its meaning is unknown.

    Args:
        tokens: Words of the property. Those of a thing, such as a water tank, or of an opposite are no condition.
        around: Words of its node, for a property with neutral words only.
    """
    if _is_object(tokens):
        return "state"
    counted = tokens if tokens & _CONDITIONS.keys() or not tokens <= _NEUTRAL else around
    if (counted is around and _is_object(around)) or not _OPPOSITES.isdisjoint(tokens | counted):
        return "state"
    return next((capability for token, capability in _CONDITIONS.items() if token in counted), "state")


_OPPOSITES = frozenset({"absent", "clear", "close", "closed", "dry", "no", "not", "ok", "safe", "shut", "vacant"})
"""Words that invert a condition: ``door-closed``, ``No motion``."""

_NEUTRAL = frozenset(
    {"active", "alarm", "alert", "detected", "detection", "detector", "sensor", "state", "status", "triggered", "value"}
)
"""Words without information about a boolean."""
