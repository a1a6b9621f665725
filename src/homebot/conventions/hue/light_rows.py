"""Lights of a Hue bridge. Pure.

``min_dim_level`` says how much light there is at the lowest brightness, and limits no brightness. The bridge moves a
colour outside of the gamut of a light to the nearest one in it, and reports that. A light with a gradient has the
colour of its first point, and takes one colour for all of them.

Source: Philips Hue, CLIP API v2 reference, resource ``light``.
"""

from __future__ import annotations

from typing import Final

from homebot.conventions.command_values import require_option, require_transition, require_true
from homebot.conventions.hue.resources import Fields, HueBody, HueRow, at
from homebot.conventions.light_color import MIRED, from_hue_saturation, nearest_mired_bounds, to_hue_saturation
from homebot.conventions.payload import text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

__all__ = ["LIGHT_ROWS", "transition_of"]

_WHITES: Final = (2000, 6500)
_MIREK: Final = (153.0, 500.0)
"""Of a light that does not say its own, or says the largest numbers of its bytes."""

_MOST_EFFECTS: Final = 50


def transition_of(command: Command) -> HueBody:
    """Return the duration of a transition, which may take 6,000 seconds, in milliseconds; nothing for none."""
    seconds = require_transition(command.transition, 6000.0)
    return {"duration": round(seconds * 1000)} if seconds else {}


def _body(command: Command, *, on: bool = True, **changes: object) -> HueBody:
    duration = transition_of(command)
    return {"on": {"on": on}, **changes, **({"dynamics": duration} if duration else {})}


def _read_on(light: Fields) -> PlainValue:
    on = at(light, "on", "on")
    return on if isinstance(on, bool) else None


def _read_level(light: Fields) -> PlainValue:
    level = finite_number(at(light, "dimming", "brightness"))
    return level if level is not None and 0 <= level <= 100 else None


def _write_level(_light: Fields, command: Command) -> HueBody:
    percent = command.value.number
    return _body(command, dimming={"brightness": round(percent, 2)}) if percent > 0 else _body(command, on=False)


def _mirek_bounds(light: Fields) -> tuple[float, float]:
    schema = at(light, "color_temperature", "mirek_schema")
    least, most = (finite_number(at(schema, name)) for name in ("mirek_minimum", "mirek_maximum"))
    return (least, most) if least is not None and most is not None and 25 <= least < most <= 1000 else _MIREK


def _kelvin_bounds(light: Fields) -> tuple[float, float]:
    return nearest_mired_bounds(*_mirek_bounds(light))


def _mirek(light: Fields) -> float | None:
    """Return the colour temperature; None while the light has a colour."""
    mirek = finite_number(at(light, "color_temperature", "mirek"))
    is_white = mirek is not None and mirek >= 1 and at(light, "color_temperature", "mirek_valid") is not False
    return mirek if is_white else None


def _read_kelvin(light: Fields) -> PlainValue:
    mirek = _mirek(light)
    return None if mirek is None else float(round(MIRED / mirek))


def _write_kelvin(light: Fields, command: Command) -> HueBody:
    least, most = _mirek_bounds(light)
    return _body(command, color_temperature={"mirek": round(min(max(MIRED / command.value.number, least), most))})


def _read_color(light: Fields) -> PlainValue:
    x, y = (finite_number(at(light, "color", "xy", name)) for name in ("x", "y"))
    if x is None or y is None or not (0 <= x <= 1 and 0 <= y <= 1) or _mirek(light) is not None:
        return None
    return to_hue_saturation("xy", (x, y), _WHITES)


def _write_color(_light: Fields, command: Command) -> HueBody:
    hue, saturation = command.value.numbers
    x, y = from_hue_saturation("xy", hue, saturation, _WHITES)
    return _body(command, color={"xy": {"x": x, "y": y}})


def _effects(light: Fields) -> tuple[str, ...]:
    listed = at(light, "effects", "effect_values")
    return tuple(text_of(one, 40) for one in listed[:_MOST_EFFECTS]) if isinstance(listed, list) else ()


def _read_effect(light: Fields) -> PlainValue:
    effect = at(light, "effects", "status")
    return effect if isinstance(effect, str) and effect in _effects(light) else None


def _write_locate(_device: Fields, command: Command) -> HueBody:
    require_true("locate", command.value.plain())
    return {"identify": {"action": "identify"}}


_COLORS: Final = frozenset({"color", "color_temperature"})

LIGHT_ROWS: Final = (
    HueRow("light", "on_off", frozenset({"on"}), _read_on, lambda _light, one: _body(one, on=one.value.flag)),
    HueRow("light", "level", frozenset({"dimming"}), _read_level, _write_level, "dimming"),
    HueRow("light", "color_temperature", _COLORS, _read_kelvin, _write_kelvin, "color_temperature", _kelvin_bounds),
    HueRow("light", "color", _COLORS, _read_color, _write_color, "color"),
    HueRow(
        "light",
        "effect",
        frozenset({"effects"}),
        _read_effect,
        lambda light, one: _body(one, effects={"effect": require_option("effect", one.value.text, _effects(light))}),
        "effects",
        options=_effects,
    ),
    HueRow("light", "locate", frozenset(), write=_write_locate, at_owner=True),
)
