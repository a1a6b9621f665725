"""Sensors, buttons, batteries and scenes of a Hue bridge. Pure.

Source: Philips Hue, CLIP API v2 reference, resources ``motion``, ``camera_motion``, ``*_area_motion``, ``temperature``,
``light_level``, ``contact``, ``tamper``, ``device_power``, ``button``, ``bell_button``, ``relative_rotary``, ``scene``
and ``smart_scene``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from homebot.conventions.command_values import require_true
from homebot.conventions.hue.light_rows import transition_of
from homebot.conventions.hue.resources import Fields, HueBody, HueRow, at
from homebot.conventions.payload import text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

__all__ = ["BUTTON_KINDS", "MOTION_KINDS", "SERVICE_ROWS", "press_of"]

MOTION_KINDS: Final = ("motion", "camera_motion", "convenience_area_motion", "security_area_motion")
BUTTON_KINDS: Final = ("button", "bell_button")

_PRESSES: Final = {
    "initial_press": "initial_press",
    "repeat": "repeat",
    "short_release": "single",
    "double_short_release": "double",
    "long_press": "long",
    "long_release": "long_release",
}
"""The events of a button, by homebot's words for those that other protocols have as well."""

_TURNS: Final = {"clock_wise": "rotate_right", "counter_clock_wise": "rotate_left"}
_LOG_STEPS, _MOST_LOG = 10_000.0, 200_000.0


def press_of(change: Fields) -> tuple[str, str]:
    """Return the press or turn in a change of a resource, and its time; both empty if there is none.

    A bridge that starts sends its buttons without a report: none was pressed then.
    """
    button, rotary = at(change, "button", "button_report"), at(change, "relative_rotary", "rotary_report")
    press = _PRESSES.get(text_of(at(button, "event"))) or _TURNS.get(text_of(at(rotary, "rotation", "direction")), "")
    return press, text_of(at(button or rotary, "updated"))


def _presses(button: Fields) -> tuple[str, ...]:
    listed = at(button, "button", "event_values")
    names = listed if isinstance(listed, list) and listed else _PRESSES
    return tuple(dict.fromkeys(_PRESSES[one] for one in names if isinstance(one, str) and one in _PRESSES))


def _sensed(sensor: Fields, feature: str, name: str) -> object:
    """Return a value from its report, or from where older firmware has it; None from a sensor that is turned off."""
    if sensor.get("enabled") is False or at(sensor, feature, f"{name}_valid") is False:
        return None
    found = at(sensor, feature, f"{name}_report", name)
    return at(sensor, feature, name) if found is None else found


def _read_motion(sensor: Fields) -> PlainValue:
    motion = _sensed(sensor, "motion", "motion")
    return motion if isinstance(motion, bool) else None


def _read_celsius(sensor: Fields) -> PlainValue:
    celsius = finite_number(_sensed(sensor, "temperature", "temperature"))
    return None if celsius is None else round(celsius, 2)  # it sends 18.139999389648438


def _read_lux(sensor: Fields) -> PlainValue:
    level = finite_number(_sensed(sensor, "light", "light_level"))
    if level is None or not 0 <= level <= _MOST_LOG:
        return None
    return round(10 ** ((level - 1) / _LOG_STEPS), 2) if level > 0 else 0.0


def _read_tamper(sensor: Fields) -> PlainValue:
    reports = sensor.get("tamper_reports")
    return any(at(one, "state") == "tampered" for one in reports) if isinstance(reports, list) and reports else None


def _words(meanings: Mapping[str, bool], *path: str) -> Callable[[Fields], PlainValue]:
    """Return the reader of a word; None for one that is unknown, or of a sensor that is turned off."""
    return lambda one: None if one.get("enabled") is False else meanings.get(text_of(at(one, *path)))


def _write_recall(action: str, _scene: Fields, command: Command) -> HueBody:
    require_true("scene", command.value.plain())
    return {"recall": {"action": action, **transition_of(command)}}


_MOTION, _WARMTH, _LIGHT = (frozenset({one, "enabled"}) for one in ("motion", "temperature", "light"))
_CONTACT, _POWER, _ANY = frozenset({"contact_report", "enabled"}), frozenset({"power_state"}), frozenset({"id"})

_read_contact = _words({"contact": False, "no_contact": True}, "contact_report", "state")
_read_low = _words({"normal": False, "low": True, "critical": True}, "power_state", "battery_state")

SERVICE_ROWS: Final = (
    *(HueRow(kind, "occupancy", _MOTION, _read_motion) for kind in MOTION_KINDS),
    HueRow("temperature", "temperature", _WARMTH, _read_celsius),
    HueRow("light_level", "illuminance", _LIGHT, _read_lux),
    HueRow("contact", "contact", _CONTACT, _read_contact),
    HueRow("tamper", "tamper", frozenset({"tamper_reports"}), _read_tamper),
    HueRow("device_power", "battery", _POWER, lambda one: finite_number(at(one, "power_state", "battery_level"))),
    HueRow("device_power", "battery_low", _POWER, _read_low),
    *(HueRow(kind, "press", _ANY, options=_presses) for kind in BUTTON_KINDS),
    HueRow("relative_rotary", "press", _ANY, options=lambda _: tuple(_TURNS.values())),
    HueRow("scene", "scene", frozenset(), write=partial(_write_recall, "active")),
    HueRow("smart_scene", "scene", frozenset(), write=partial(_write_recall, "activate")),
)
