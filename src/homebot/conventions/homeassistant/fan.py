"""The component ``fan``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/fan.py``.
"""

from __future__ import annotations

import math

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.conversion import Scale, whole_of
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["build_fan"]


def build_fan(config: DiscoveryConfig) -> DescribedPart:
    """Describe a fan."""
    entity = Entity(config, "fan")
    _add_switch(
        entity,
        config,
        "on_off",
        config.required_command(),
        ("state_topic", "state_value_template"),
        {config.text("payload_off", "OFF"): False, config.text("payload_on", "ON"): True, "None": None},
    )
    _add_speed(entity, config)
    _add_preset(entity, config)
    _add_switch(
        entity,
        config,
        "oscillation",
        config.command("oscillation_command_topic", "oscillation_command_template"),
        ("oscillation_state_topic", "oscillation_value_template"),
        {
            config.text("payload_oscillation_off", "oscillate_off"): False,
            config.text("payload_oscillation_on", "oscillate_on"): True,
        },
    )
    _add_direction(entity, config)
    return entity.build()


_DIRECTIONS = ("forward", "reverse")


def _add_switch(
    entity: Entity,
    config: DiscoveryConfig,
    name: str,
    command: CommandTopic | None,
    source: tuple[str, str],
    states: dict[str, bool | None],
) -> None:
    payloads = {flag: payload for payload, flag in states.items()}

    def read(text: str) -> Readings:
        return {name: states[text]} if text in states else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(payloads[require_bool(name, value)]),) if command else ()

    entity.add_capability(
        name, readable=entity.read_text_from(config.source(*source), read), writer=write if command else None
    )
    entity.add_commands(command)


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

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        percent = round(require_number("fan_speed", value, 0, 100, "%"))
        return (command.publication(math.ceil(scale.value(percent))),) if command else ()

    source = config.source("percentage_state_topic", "percentage_value_template")
    entity.add_capability("fan_speed", readable=entity.read_text_from(source, read), writer=write if command else None)
    entity.add_commands(command)


def _add_preset(entity: Entity, config: DiscoveryConfig) -> None:
    modes = config.options("preset_modes")
    unknown = config.text("payload_reset_preset_mode", "None")
    command = config.command("preset_mode_command_topic", "preset_mode_command_template")
    if unknown in modes:
        raise WireError(f"fan: preset_modes has {shown(unknown)}, which means that the mode is unknown")

    def read(text: str) -> Readings:
        if text == unknown:
            return {"preset_mode": None}
        return {"preset_mode": text} if text in modes else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(require_option("preset_mode", value, modes)),) if command else ()

    source = config.source("preset_mode_state_topic", "preset_mode_value_template") if modes else None
    entity.add_capability(
        "preset_mode",
        readable=entity.read_text_from(source, read),
        writer=write if command and modes else None,
        options=modes,
    )
    entity.add_commands(command)


def _add_direction(entity: Entity, config: DiscoveryConfig) -> None:
    command = config.command("direction_command_topic", "direction_command_template")

    def read(text: str) -> Readings:
        return {"direction": text} if text in _DIRECTIONS else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(require_option("direction", value, _DIRECTIONS)),) if command else ()

    source = config.source("direction_state_topic", "direction_value_template")
    entity.add_capability("direction", readable=entity.read_text_from(source, read), writer=write if command else None)
    entity.add_commands(command)
