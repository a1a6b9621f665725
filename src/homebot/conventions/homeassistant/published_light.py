"""A lamp that is offered, as a Home Assistant's light of schema ``json``: one object reports it, one commands it. Pure.

Source: Home Assistant core 2024.3 to 2025.4, ``components/mqtt/light/schema_json.py``.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.homeassistant.published_entity import (
    Available,
    CommandReader,
    EntityTopics,
    PublishedEntity,
    StateWriter,
    Values,
)
from homebot.conventions.light_color import kelvin_mired
from homebot.conventions.payload import compact_json, number_of, parse_json
from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["publish_light"]


def publish_light(part: Part, available: Available, topics: EntityTopics) -> tuple[PublishedEntity, ...]:
    """Take what a light can have out of *available*; nothing where *part* is no lamp that can be switched.

    A white or a colour belongs to it only where its brightness can be set: Home Assistant knows no other.
    """
    if part.service_type != "light" or not _is_settable(available, "on_off"):
        return ()
    switch = available.pop("on_off")
    names = ("level",) if _is_settable(available, "level") else ()
    taken = {
        name: available.pop(name) for name in (*names, *(_TINTS if names else ())) if _is_settable(available, name)
    }
    if _is_settable(available, "effect"):
        taken["effect"] = available.pop("effect")
    config: dict[str, object] = {"schema": "json", "color_mode": True, "supported_color_modes": _modes(taken)}
    if "level" in taken:
        config["brightness"] = True
    if "color_temperature" in taken:
        low, high = taken["color_temperature"].bounds or _WHITES
        config |= {"min_mireds": max(1, kelvin_mired(high)), "max_mireds": max(2, kelvin_mired(low))}
    if "effect" in taken:
        config["effect"] = True
        if taken["effect"].options:
            config["effect_list"] = list(taken["effect"].options)
    entity = PublishedEntity(topics, "light", "", config)
    if switch.readable:
        entity.add_state("state_topic", "light", _written(frozenset(taken)), ("on_off", *taken))
    entity.add_command("command_topic", "light", _reader(frozenset(taken)))
    return (entity,)


_TINTS = ("color_temperature", "color")
_WHITES = (2_000.0, 6_500.0)
_FULL = 255
_LONGEST_EFFECT = 255


def _is_settable(available: Available, name: str) -> bool:
    return name in available and available[name].settable


def _modes(taken: Mapping[str, object]) -> list[str]:
    modes = [mode for name, mode in (("color_temperature", "color_temp"), ("color", "hs")) if name in taken]
    return modes or ["brightness" if "level" in taken else "onoff"]


def _written(taken: frozenset[str]) -> StateWriter:
    def write(values: Values) -> str:
        on, level = values.get("on_off"), values.get("level")
        message: dict[str, object] = {"state": None if on is None else ("ON" if on else "OFF")}
        if "level" in taken and isinstance(level, float) and level > 0:
            message["brightness"] = max(1, round(level * _FULL / 100))
        message |= _tint(values, taken)
        if "effect" in taken and isinstance(values.get("effect"), str):
            message["effect"] = values["effect"]
        return compact_json(message)

    return write


def _tint(values: Values, taken: frozenset[str]) -> Mapping[str, object]:
    color, white = values.get("color"), values.get("color_temperature")
    if "color" in taken and isinstance(color, tuple):
        return {"color_mode": "hs", "color": {"h": color[0], "s": color[1]}}
    if "color_temperature" in taken and isinstance(white, float) and white > 0:
        return {"color_mode": "color_temp", "color_temp": kelvin_mired(white)}
    if not taken & frozenset(_TINTS):
        return {"color_mode": "brightness" if "level" in taken else "onoff"}
    return {}


def _reader(taken: frozenset[str]) -> CommandReader:
    def read(text: str) -> Values:
        try:
            message = parse_json(text)
        except WireError:
            return {}
        if not isinstance(message, dict) or message.get("state") not in ("ON", "OFF"):
            return {}
        if message["state"] == "OFF":
            return {"on_off": False}
        values = {name: value for name, value in _read_values(message).items() if name in taken and value is not None}
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
