"""Types of nodes, and quantities by units. Tables, pure.

Source: hc-smarthome v2 and v1 (homie-homecontrol/hc-homie5-smarthome); homie5-device-profiles, draft; Homie
convention 5, Units.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.units import measured_in


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
    "controls": Kind(  # Homie4 0.4 (PyPI), Device_Thermostat
        "thermostat",
        {
            "heatsetpoint": "heating_setpoint",
            "coolsetpoint": "cooling_setpoint",
            "systemmode": "thermostat_mode",
            "fanmode": "fan_mode",
        },
    ),
    **{name: Kind() for name in ("climate", "weather", "illuminance", "powermeter", "air-quality", "numeric", "scene")},
}
"""Kinds by the name at the end of a node's type."""

_DECLARED = re.compile(
    r"(?:hc-smarthome/v[0-9]+/cap/|(?:homie-homecontrol|hc-smarthome|homie-capability-profile)/v[0-9]+/type=)"
    r"([a-z0-9-]{1,40})"
)
_CLASS = re.compile(r"(?:hc-smarthome/v[0-9]+/dc/|homie-device-profile/v[0-9]+/type=)([a-z0-9-]{1,40})")

_TOKEN = re.compile(r"[a-z]+[0-9]*")
_MAX_CHARACTERS = 200


def declared_kind(node_type: str) -> str:
    """Return the name of the declared kind of *node_type*; empty if it is unknown."""
    match = _DECLARED.fullmatch(node_type)
    return match[1] if match is not None and match[1] in KINDS else ""


def declared_class(device_type: str) -> str:
    """Return the declared class of a device, such as ``light`` or ``outlet``; empty for none."""
    match = _CLASS.fullmatch(device_type)
    return match[1] if match is not None else ""


def tokens_in(*texts: str) -> frozenset[str]:
    """Return the words of *texts* in small letters."""
    return frozenset(token for text in texts for token in _TOKEN.findall(text[:_MAX_CHARACTERS].casefold()))


_RATINGS = frozenset({"advertised", "limit", "maximum", "nameplate", "nominal", "rated", "rating", "soe"})
"""Words for purposes, limits and contents, which are not measured: a breaker of 200 A."""

_RETURNED = frozenset({"export", "exported", "returned"})


_SHARES = ("battery", "humidity")
"""Quantities in percent by their words: of robots by Valetudo, and of the node ``status`` of Homie4 0.4 (PyPI)."""


def quantity_of(unit: str, tokens: frozenset[str]) -> str:
    """Return the capability of a number by its unit.

    Args:
        tokens: The words of its property and its node: a few of products that people own decide too.
    """
    unit = unit.strip()
    if not tokens.isdisjoint(_RATINGS):
        return "measurement"
    if unit == "%":
        return next((name for name in _SHARES if any(token.startswith(name) for token in tokens)), "measurement")
    if unit == "dBm":
        return "signal_strength"
    capability = measured_in(unit) or "measurement"
    return "energy_returned" if capability == "energy" and tokens & _RETURNED else capability
