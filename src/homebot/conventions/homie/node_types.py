"""Types of nodes, and the meaning of their properties. Tables, pure.

Source: hc-smarthome v2 and v1 (homie-homecontrol/hc-homie5-smarthome); homie5-device-profiles, draft.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from homebot.conventions.homie.model import HomieNode

__all__ = ["KINDS", "Kind", "declared_class", "declared_kind", "guessed_kinds", "tokens_in"]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of node.

    Attributes:
        service_type: Of what it controls; empty where it only tells.
        roles: What each property does, by its id.
        condition: What its first truth tells, whatever its id.
        tag: See :attr:`homebot.devices.Part.tag`.
    """

    service_type: str = ""
    roles: Mapping[str, str] = field(default_factory=dict)
    condition: str = ""
    tag: str = ""


_SWITCH = {"state": "on_off"}
_LEVEL = {"value": "level", "brightness": "level"}
_COLOR = {"color": "color", "color-temperature": "color_temperature"}

KINDS: Mapping[str, Kind] = MappingProxyType(
    {
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
        **{
            name: Kind()
            for name in ("climate", "weather", "illuminance", "powermeter", "air-quality", "numeric", "scene")
        },
    }
)
"""Kinds by the name at the end of a node's type."""

_DECLARED = re.compile(
    r"(?:hc-smarthome/v[0-9]+/cap/|(?:homie-homecontrol|hc-smarthome|homie-capability-profile)/v[0-9]+/type=)"
    r"([a-z0-9-]{1,40})"
)
_CLASS = re.compile(r"(?:hc-smarthome/v[0-9]+/dc/|homie-device-profile/v[0-9]+/type=)([a-z0-9-]{1,40})")

_GUESSES: tuple[tuple[str, frozenset[str]], ...] = (
    ("garage-door", frozenset({"garage"})),
    ("shutter", frozenset({"shutter", "blind", "blinds", "cover", "curtain", "roller", "awning", "shade"})),
    ("lock", frozenset({"lock"})),
    ("thermostat", frozenset({"thermostat", "heater", "heating", "radiator", "setpoint", "heatsetpoint"})),
    ("fan", frozenset({"fan", "ventilator"})),
    ("valve", frozenset({"valve"})),
    ("light", frozenset({"light", "lamp", "bulb", "led", "dimmer", "strip", "rgb", "luminaire", "lighting"})),
)
_TOKEN = re.compile(r"[a-z]+[0-9]*")
_LONGEST = 200


def declared_kind(node_type: str) -> str:
    """Return the name of the kind that *node_type* declares; empty where it declares none that is known."""
    match = _DECLARED.fullmatch(node_type)
    return match[1] if match is not None and match[1] in KINDS else ""


def declared_class(device_type: str) -> str:
    """Return what a device declares to be, such as ``light`` or ``outlet``; empty where it does not."""
    match = _CLASS.fullmatch(device_type)
    return match[1] if match is not None else ""


def guessed_kinds(node: HomieNode, around: frozenset[str]) -> tuple[str, ...]:
    """Return the kinds that the words of *node* speak of, then those of which the words *around* it do."""
    own = tokens_in(node.type, node.id, node.name, *(prop.id for prop in node.properties))
    return tuple(dict.fromkeys(kind for tokens in (own, around) for kind, hints in _GUESSES if tokens & hints))


def tokens_in(*texts: str) -> frozenset[str]:
    """Return the words of *texts* in small letters."""
    return frozenset(token for text in texts for token in _TOKEN.findall(text[:_LONGEST].casefold()))
