"""Lamps: on and off, brightness and colour, perhaps in nodes of their own. Pure.

Setting the brightness or the colour also switches the lamp on: Homie leaves that to the controller.

Source: homie5-device-profiles, Light; hc-smarthome v2, switch, level and color.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import require_bool, require_color, require_number
from homebot.conventions.description import Publications
from homebot.conventions.homie.model import HomieProperty
from homebot.conventions.homie.property_codecs import add_flag, percent_of, percent_written
from homebot.conventions.homie.values import publication, read_color, read_plain, spell_color, spell_plain
from homebot.conventions.light_color import MIRED, nearest_mired_bounds
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.value import PlainValue

__all__ = ["LIGHT_ROLES", "add_light"]

LIGHT_ROLES = ("on_off", "level", "color", "color_temperature")
"""Roles that a lamp may have, each once."""

_KELVIN = (1000.0, 40_000.0)


def add_light(part: BytesPart, props: Mapping[str, HomieProperty]) -> None:
    """Add the capabilities of a lamp, from its properties by role."""
    lamp = _HomieLamp(props.get("on_off"))
    level, color, white = (props.get(role) for role in ("level", "color", "color_temperature"))
    if lamp.switch is not None:
        add_flag(part, lamp.switch)
    if level is not None:
        _add_level(part, lamp, level)
    if color is not None:
        _add_color(part, lamp, color, has_level=level is not None)
    if white is not None:
        _add_white(part, lamp, white)


@dataclass(frozen=True, slots=True)
class _HomieLamp:
    switch: HomieProperty | None

    def switched(self, *, on: bool) -> Publications:
        if self.switch is None or not self.switch.is_settable:
            return ()
        return (publication(self.switch, "true" if on else "false"),)


def _add_level(part: BytesPart, lamp: _HomieLamp, level: HomieProperty) -> None:
    is_switch = lamp.switch is None

    def read(payload: bytes) -> Readings:
        percent = percent_of(level, payload)
        if percent is None:
            return NO_READINGS
        return {"level": percent, "on_off": percent > 0} if is_switch else {"level": percent}

    def dim(value: PlainValue, _transition: float) -> Publications:
        percent = require_number("level", value, 0, 100, "%")
        if percent == 0 and (off := lamp.switched(on=False)):
            return off
        return (percent_written(level, "level", percent), *lamp.switched(on=True))

    def switch(value: PlainValue, _transition: float) -> Publications:
        return (percent_written(level, "level", 100.0 if require_bool("on_off", value) else 0.0),)

    part.read_from(level.topic, read)
    part.add_capability("level", readable=level.is_retained, writer=dim if level.is_settable else None)
    if level.is_settable:
        part.add_command_topics(f"{level.topic}/set")
    if is_switch:
        part.add_capability("on_off", readable=level.is_retained, writer=switch if level.is_settable else None)


def _add_color(part: BytesPart, lamp: _HomieLamp, color: HomieProperty, *, has_level: bool) -> None:
    def read(payload: bytes) -> Readings:
        value = read_color(color, payload)
        if value is None:
            return NO_READINGS
        hue, saturation, brightness = value
        if has_level or brightness is None:
            return {"color": (hue, saturation)}
        return {"color": (hue, saturation), "level": brightness}

    def paint(value: PlainValue, _transition: float) -> Publications:
        hue, saturation = require_color(value)
        return (publication(color, spell_color(color, hue, saturation)), *lamp.switched(on=True))

    part.read_from(color.topic, read)
    part.add_capability("color", readable=color.is_retained, writer=paint if color.is_settable else None)
    if not has_level and set(color.options) & {"hsv", "rgb"}:
        part.add_capability("level")
    if color.is_settable:
        part.add_command_topics(f"{color.topic}/set")


def _add_white(part: BytesPart, lamp: _HomieLamp, white: HomieProperty) -> None:
    is_kelvin = white.unit.strip() == "K" or (white.range.most is not None and white.range.most > 1000)

    def read(payload: bytes) -> Readings:
        value = read_plain(white, payload)
        if not isinstance(value, float) or value <= 0:
            return NO_READINGS
        return {"color_temperature": value if is_kelvin else float(round(MIRED / value))}

    def warm(value: PlainValue, _transition: float) -> Publications:
        least, most = bounds or _KELVIN
        kelvin = require_number("color_temperature", value, least, most, "K")
        number = white.range.kept(round(kelvin if is_kelvin else MIRED / kelvin, digits))
        return (publication(white, spell_plain(white, "color_temperature", number)), *lamp.switched(on=True))

    bounds = _white_bounds(white, is_kelvin=is_kelvin)
    digits = 0 if white.datatype == "integer" else 3
    part.read_from(white.topic, read)
    part.add_capability(
        "color_temperature",
        readable=white.is_retained,
        writer=warm if white.is_settable else None,
        bounds=bounds,
    )
    if white.is_settable:
        part.add_command_topics(f"{white.topic}/set")


def _white_bounds(white: HomieProperty, *, is_kelvin: bool) -> tuple[float, float] | tuple[()]:
    """Return the bounds in kelvin; of a lamp in mired, those that are within after rounding to whole mired."""
    least, most = white.range.least, white.range.most
    if least is None or most is None or not 1 <= least < most:
        return ()
    if is_kelvin:
        return least, most
    return nearest_mired_bounds(least, most)
