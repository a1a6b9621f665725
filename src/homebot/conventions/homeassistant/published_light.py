"""A published lamp, as a light of schema ``json``: one object reports it, one commands it. Pure.

Source: Home Assistant core 2024.3 to 2025.4, ``components/mqtt/light/schema_json.py``.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.homeassistant.published_entity import (
    Available,
    CommandReader,
    PublishedEntity,
    StateWriter,
    Values,
    is_settable,
)
from homebot.conventions.light_color import kelvin_mired
from homebot.conventions.payload import compact_json, number_of, parse_json
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["publish_light"]


_TINTS = ("color_temperature", "color")
_WHITES = (2_000.0, 6_500.0)
_FULL = 255
_LONGEST_EFFECT = 255


def publish_light(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish a lamp that can be switched.

    White and colour belong to it only if its brightness can be set: Home Assistant knows no other lamps.
    """
    switch = available.pop("on_off")
    names = ("level", *_TINTS, "effect") if is_settable(available, "level") else ("effect",)
    lamp = {name: available.pop(name) for name in names if is_settable(available, name)}
    entity.config |= _config(lamp)
    if switch.readable:
        entity.add_state("state_topic", "light", _state_writer(frozenset(lamp)), ("on_off", *lamp))
    entity.add_command("command_topic", "light", _command_reader(frozenset(lamp)))


def _config(lamp: Mapping[str, Capability]) -> dict[str, object]:
    config: dict[str, object] = {"schema": "json", "color_mode": True, "supported_color_modes": _modes(lamp)}
    if "level" in lamp:
        config["brightness"] = True
    if "color_temperature" in lamp:
        low, high = lamp["color_temperature"].bounds or _WHITES
        config |= {"min_mireds": max(1, kelvin_mired(high)), "max_mireds": max(2, kelvin_mired(low))}
    if "effect" in lamp:
        config["effect"] = True
        if lamp["effect"].options:
            config["effect_list"] = list(lamp["effect"].options)
    return config


def _modes(lamp: Mapping[str, object]) -> list[str]:
    modes = [mode for name, mode in (("color_temperature", "color_temp"), ("color", "hs")) if name in lamp]
    return modes or ["brightness" if "level" in lamp else "onoff"]


def _state_writer(lamp: frozenset[str]) -> StateWriter:
    def write(values: Values) -> str:
        on, level = values.get("on_off"), values.get("level")
        message: dict[str, object] = {"state": None if on is None else ("ON" if on else "OFF")}
        if "level" in lamp and isinstance(level, float) and level > 0:
            message["brightness"] = max(1, round(level * _FULL / 100))
        message |= _tint(values, lamp)
        if "effect" in lamp and isinstance(values.get("effect"), str):
            message["effect"] = values["effect"]
        return compact_json(message)

    return write


def _tint(values: Values, lamp: frozenset[str]) -> Mapping[str, object]:
    color, white = values.get("color"), values.get("color_temperature")
    if "color" in lamp and isinstance(color, tuple):
        return {"color_mode": "hs", "color": {"h": color[0], "s": color[1]}}
    if "color_temperature" in lamp and isinstance(white, float) and white > 0:
        return {"color_mode": "color_temp", "color_temp": kelvin_mired(white)}
    if not lamp & frozenset(_TINTS):
        return {"color_mode": "brightness" if "level" in lamp else "onoff"}
    return {}


def _command_reader(lamp: frozenset[str]) -> CommandReader:
    def read(text: str) -> Values:
        try:
            message = parse_json(text)
        except WireError:
            return {}
        if not isinstance(message, dict) or message.get("state") not in ("ON", "OFF"):
            return {}
        if message["state"] == "OFF":
            return {"on_off": False}
        values = {name: value for name, value in _read_values(message).items() if name in lamp and value is not None}
        return {**values, "on_off": True}

    return read


def _read_values(message: Mapping[str, object]) -> Values:
    brightness, mired, effect = (
        number_of(message.get("brightness")),
        number_of(message.get("color_temp")),
        message.get("effect"),
    )
    return {
        "color": _color(message.get("color")),
        "color_temperature": float(kelvin_mired(mired)) if mired is not None and mired >= 1 else None,
        "level": round(brightness * 100 / _FULL, 2) if brightness is not None and 0 < brightness <= _FULL else None,
        "effect": effect if isinstance(effect, str) and len(effect) <= _LONGEST_EFFECT else None,
    }


def _color(color: object) -> PlainValue:
    if not isinstance(color, dict):
        return None
    hue, saturation = number_of(color.get("h")), number_of(color.get("s"))
    if hue is None or saturation is None or not (0 <= hue <= 360 and 0 <= saturation <= 100):
        return None
    return (hue, saturation)
