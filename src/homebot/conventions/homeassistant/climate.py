"""The component ``climate``: thermostats, radiator valves, air conditioners, heat pumps. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/climate.py`` and ``components/climate/__init__.py``.
"""

from __future__ import annotations

from functools import partial

from homebot.conventions.command_values import require_bool
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.temperature import (
    TargetMode,
    add_temperatures,
    source_at,
    source_of,
)
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

__all__ = ["build_climate"]


def build_climate(config: DiscoveryConfig) -> DescribedPart:
    """Describe a thermostat, or an air conditioner where it can cool and also dry or only blow."""
    modes = _modes(config)
    is_conditioner = "cool" in modes and ("dry" in modes or "fan_only" in modes)
    entity = Entity(config, "room_air_conditioner" if is_conditioner else "thermostat")
    target_mode = TargetMode(is_reported=config.has("mode_state_topic") and not config.flag("optimistic"))
    add_temperatures(entity, config, modes, target_mode)
    _add_humidity(entity, config)
    mode = config.command("mode_command_topic", "mode_command_template")
    entity.add_choice(
        "thermostat_mode", source_of(config, "mode_state"), mode, modes, on_command=target_mode.on_command
    )
    _add_switch(entity, config, mode, modes, target_mode)
    entity.add_choice("thermostat_action", source_at(config, "action_topic", "action_template"), None, _ACTIONS)
    for name, default in _CHOICES.items():
        command = config.command(f"{name}_command_topic", f"{name}_command_template")
        options = config.options(f"{name}s") if config.has(f"{name}s") else default
        entity.add_choice(name, source_of(config, f"{name}_state"), command, options)
    _add_preset(entity, config)
    return entity.build()


_MODES = ("auto", "off", "cool", "heat", "dry", "fan_only")
_ACTIONS = ("off", "heating", "cooling", "drying", "idle", "fan", "preheating", "defrosting")
_CHOICES = {"fan_mode": ("auto", "low", "medium", "high"), "swing_mode": ("on", "off")}
"""Default options by capability, which is also the beginning of the fields."""

_PAIR = 2
_SHOWN = 200
_SWITCHED_ON = ("heat_cool", "heat", "cool")


def _modes(config: DiscoveryConfig) -> tuple[str, ...]:
    """Return its modes; those of Home Assistant for a mode without a list.

    A valve without a mode has none, although Home Assistant shows it with all of its own: it is no air conditioner.
    """
    if config.has("modes"):
        return config.options("modes")
    return _MODES if config.has("mode_command_topic") or config.has("mode_state_topic") else ()


def _add_humidity(entity: Entity, config: DiscoveryConfig) -> None:
    entity.add_number("humidity", source_of(config, "current_humidity"), None, unit="%")
    command = config.command("target_humidity_command_topic", "target_humidity_command_template")
    source = source_of(config, "target_humidity_state")
    least, most = config.number("min_humidity", 30.0), config.number("max_humidity", 99.0)
    if least >= most or most > 100:
        raise WireError(f"climate: max_humidity is {most:g}, not above min_humidity {least:g} and at most 100")
    if source is not None and command is None:
        raise WireError("climate: target_humidity_state_topic needs target_humidity_command_topic")
    entity.add_number("humidity_setpoint", source, command, bounds=(least, most), unit="%", to_device=int)


def _add_switch(
    entity: Entity, config: DiscoveryConfig, mode: CommandTopic | None, modes: tuple[str, ...], target_mode: TargetMode
) -> None:
    """Add ``on_off``: with a topic of its own, or else by the mode, as in Home Assistant."""
    power = config.command("power_command_topic", "power_command_template")
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    command = power or mode
    texts = payloads if power else _modes_of_switch(modes)
    source = source_of(config, "mode_state") if "off" in modes else None

    def write(value: PlainValue, _transition: float) -> Publications:
        is_on = require_bool("on_off", value)
        if is_on not in texts:
            raise RefusedError(f"on_off {shown(value)}", f"none of its modes is that: {', '.join(modes)[:_SHOWN]}")
        publications = command.publish(texts[is_on]) if command else ()
        if power is None:
            target_mode.on_command(texts[is_on])
        return publications

    is_readable = entity.read_text_from(source, partial(_read_switch, modes))
    entity.add_capability("on_off", readable=is_readable, writer=write if command and texts else None)
    entity.add_commands(power)


def _modes_of_switch(modes: tuple[str, ...]) -> dict[bool, str]:
    """Return the modes of on and off. Of two modes, any other one than off is on."""
    is_pair = len(modes) == _PAIR and "off" in modes
    on = [mode for mode in (modes if is_pair else _SWITCHED_ON) if mode in modes and mode != "off"]
    return {**({True: on[0]} if on else {}), **({False: "off"} if "off" in modes else {})}


def _read_switch(modes: tuple[str, ...], text: str) -> Readings:
    if text == "None":
        return {"on_off": None}
    return {"on_off": text != "off"} if text in modes else NO_READINGS


def _add_preset(entity: Entity, config: DiscoveryConfig) -> None:
    presets = config.options("preset_modes")
    if "none" in presets:
        raise WireError("climate: preset_modes has none, which means that there is no preset")
    command = config.command("preset_mode_command_topic", "preset_mode_command_template")
    if presets and command is not None:
        source = source_at(config, "preset_mode_state_topic", "preset_mode_value_template")
        entity.add_choice("preset_mode", source, command, ("none", *presets), meanings={"None": "none"})
