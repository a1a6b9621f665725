"""The component ``lawn_mower``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/lawn_mower.py``.
"""

from __future__ import annotations

from homebot.conventions.command_values import option_writer
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings

__all__ = ["build_lawn_mower"]


def build_lawn_mower(config: DiscoveryConfig) -> DescribedPart:
    """Describe a robot that mows; each of its commands has a topic of its own."""
    commands = {
        state: (command, action)
        for state, action in _ACTIONS.items()
        if (command := config.command(f"{action}_command_topic", f"{action}_command_template")) is not None
    }

    def read(text: str) -> Readings:
        if text.lower() == "none":
            return {"mower": None}
        return {"mower": text} if text in _STATES else NO_READINGS

    def publish(state: str) -> Publications:
        command, action = commands[state]
        return command.publish(action)

    entity = Entity(config, "x_lawn_mower")
    source = config.source("activity_state_topic", "activity_value_template")
    writer = option_writer("mower", commands, publish) if commands else None
    is_readable = entity.read_text_from(source, read)
    entity.add_capability("mower", readable=is_readable, writer=writer, options=tuple(commands))
    entity.add_commands(*(command for command, _ in commands.values()))
    return entity.build()


_ACTIONS = {"mowing": "start_mowing", "paused": "pause", "docked": "dock"}
_STATES = frozenset({"mowing", "paused", "docked", "returning", "error"})
