"""A published lamp, as a light of schema ``json``: one object reports it, one commands it. Pure.

Source: Home Assistant core 2024.3 to 2026.11, ``components/mqtt/light/schema_json.py``.
"""

from collections.abc import Mapping

from homebot.conventions.lamp import LightCommand
from homebot.conventions.light_color import kelvin_mired
from homebot.conventions.payload import compact_json
from homebot.devices.part import Part
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.light_messages import JsonLight
from homebot.integrations.homeassistant.formats.published_entity import Available, PublishedEntity, Values, is_settable

_TINTS = ("color", "color_temperature")
_WHITES = (2_000.0, 6_500.0)


def publish_light(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish a lamp that can be switched.

    White and colour belong to it only if its brightness can be set: Home Assistant knows no other lamps.
    """
    switch = available.pop("on_off")
    names = (*_TINTS, "level", "effect") if is_settable(available, "level") else ("effect",)
    lamp = {name: available.pop(name) for name in names if is_settable(available, name)}

    def write(values: Values) -> str:
        command = _command_of({name: values.get(name) for name in ("on_off", *lamp)})
        message = light.message(command)
        if values.get("on_off") is None:
            message["state"] = None
        if command.mode or lamp.keys().isdisjoint(_TINTS):
            message["color_mode"] = command.mode or _modes(lamp)[0]
        return compact_json(message)

    def read(text: str) -> Values:
        readings = light.read(text.encode())
        if readings.get("on_off") is not True:
            return {"on_off": False} if readings.get("on_off") is False else {}
        return {**{name: readings[name] for name in lamp if readings.get(name) is not None}, "on_off": True}

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
    entity.config |= config
    if switch.readable:
        entity.add_state("state_topic", "light", write, ("on_off", *lamp))
    entity.add_command("command_topic", "light", read)
    light = JsonLight(DiscoveryConfig("light", "", {**entity.config, "effect_list": None}))


def _command_of(values: Values) -> LightCommand:
    """Return the command that would set the *values*."""
    command = LightCommand(on=values["on_off"] is True)
    match values.get("color"), values.get("color_temperature"):
        case tuple() as color, _:
            command = command._replace(mode="hs", color=color)
        case _, float() as white if white > 0:
            command = command._replace(mode="color_temp", white=white)
    level, effect = values.get("level"), values.get("effect")
    if isinstance(level, float) and level > 0:
        command = command._replace(level=level)
    return command._replace(effect=effect) if isinstance(effect, str) else command


def _modes(lamp: Mapping[str, object]) -> list[str]:
    modes = [mode for name, mode in (("color_temperature", "color_temp"), ("color", "hs")) if name in lamp]
    return modes or ["brightness" if "level" in lamp else "onoff"]
