"""The component ``fan``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/fan.py``.
"""

from __future__ import annotations

import math

from homebot.conventions.command_values import number_writer, option_writer
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity, Scale
from homebot.conventions.payload import NO_READINGS, Readings, meaning_reader, shown, whole_of
from homebot.errors import WireError

__all__ = ["build_fan"]


def build_fan(config: DiscoveryConfig) -> DescribedPart:
    """Describe a fan."""
    entity = Entity(config, "fan")
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    entity.add_flag(
        "on_off",
        config.source("state_topic", "state_value_template"),
        config.required_command(),
        payloads,
        {payloads[False]: False, payloads[True]: True, "None": None},
    )
    _add_speed(entity, config)
    _add_preset(entity, config)
    payloads = {
        True: config.text("payload_oscillation_on", "oscillate_on"),
        False: config.text("payload_oscillation_off", "oscillate_off"),
    }
    entity.add_flag(
        "oscillation",
        config.source("oscillation_state_topic", "oscillation_value_template"),
        config.command("oscillation_command_topic", "oscillation_command_template"),
        payloads,
        {payloads[False]: False, payloads[True]: True},
    )
    command = config.command("direction_command_topic", "direction_command_template")
    entity.add_value(
        "direction",
        config.source("direction_state_topic", "direction_value_template"),
        meaning_reader("direction", {direction: direction for direction in _DIRECTIONS}),
        command,
        option_writer("direction", _DIRECTIONS, command.publish) if command else None,
    )
    return entity.build()


_DIRECTIONS = ("forward", "reverse")


def _add_speed(entity: Entity, config: DiscoveryConfig) -> None:
    least = config.integer("speed_range_min", 1, least=1)
    most = config.integer("speed_range_max", 100, least=1)
    if least >= most:
        raise WireError(f"fan: speed_range_max is {most}, not above speed_range_min {least}")
    scale = Scale(least - 1, most)
    unknown = config.text("payload_reset_percentage", "None")
    command = config.command("percentage_command_topic", "percentage_command_template")

    def read(text: str) -> Readings:
        if text == unknown:
            return {"fan_speed": None}
        speed = whole_of(text)
        percent = -1.0 if speed is None else scale.percent(speed)
        return {"fan_speed": percent} if 0 <= percent <= 100 else NO_READINGS

    def publish(percent: float) -> Publications:
        return command.publish(math.ceil(scale.value(round(percent)))) if command else ()

    source = config.source("percentage_state_topic", "percentage_value_template")
    writer = number_writer("fan_speed", (0, 100), "%", publish) if command else None
    entity.add_value("fan_speed", source, read, command, writer)


def _add_preset(entity: Entity, config: DiscoveryConfig) -> None:
    modes = config.options("preset_modes")
    unknown = config.text("payload_reset_preset_mode", "None")
    command = config.command("preset_mode_command_topic", "preset_mode_command_template")
    if unknown in modes:
        raise WireError(f"fan: preset_modes has {shown(unknown)}, which means that the mode is unknown")

    source = config.source("preset_mode_state_topic", "preset_mode_value_template") if modes else None
    read = meaning_reader("preset_mode", {**{mode: mode for mode in modes}, unknown: None})
    writer = option_writer("preset_mode", modes, command.publish) if command and modes else None
    entity.add_value("preset_mode", source, read, command, writer, options=modes)
