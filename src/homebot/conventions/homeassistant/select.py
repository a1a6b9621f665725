"""The component ``select``: a setting with a list of options. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/select.py``.
"""

from __future__ import annotations

from homebot.conventions.command_values import option_writer
from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import Readings, meaning_reader
from homebot.errors import WireError

__all__ = ["build_select"]


def build_select(config: DiscoveryConfig) -> DescribedPart:
    """Describe a choice. Where it says ``none``, however that is written, the option is unknown."""
    if not config.has("options"):
        raise WireError("select: options is None, not a list of texts")
    options = config.options("options")
    command = config.required_command()
    read_option = meaning_reader("option", {option: option for option in options if option.strip()})

    def read(text: str) -> Readings:
        return {"option": None} if text.lower() == "none" else read_option(text)

    entity = Entity(config, "x_setting")
    writer = option_writer("option", options, command.publish)
    entity.add_value("option", config.source("state_topic"), read, command, writer, options=options)
    return entity.build()
