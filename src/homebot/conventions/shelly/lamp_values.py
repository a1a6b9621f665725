"""Values of lamps as both generations of Shelly spell them. Pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from homebot.conventions.light_color import to_hue_saturation
from homebot.conventions.payload import Readings
from homebot.devices.value import PlainValue
from homebot.support.numbers import to_number

__all__ = ["read_lamp", "read_rgb"]

_CHANNELS = 3
_ANY_WHITE = (2700, 6500)  # without meaning for red, green and blue


def read_lamp(fields: Mapping[str, object], on_key: str, level_key: str) -> Readings:
    """Return switch and level of a lamp, as far as *fields* have them."""
    found: dict[str, PlainValue] = {}
    if isinstance(on := fields.get(on_key), bool):
        found["on_off"] = on
    level = to_number(fields.get(level_key))
    if level is not None and 0 <= level <= 100:
        found["level"] = level
    return found


def read_rgb(values: Sequence[object]) -> tuple[float, float] | None:
    """Return hue and saturation of three channels from 0 to 255; None for other values."""
    channels = tuple(channel for channel in map(to_number, values) if channel is not None and 0 <= channel <= 255)
    if len(values) != _CHANNELS or len(channels) != _CHANNELS:
        return None
    return to_hue_saturation("rgb", channels, _ANY_WHITE)
