"""The component ``select``: a setting with a list of options. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/select.py``.
"""

from __future__ import annotations

from homebot.conventions.command_values import require_option
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["build_select"]


def build_select(config: DiscoveryConfig) -> DescribedPart:
    """Describe a choice. Where it says ``none``, however that is written, the option is unknown."""
    if not config.has("options"):
        raise WireError("select: options is None, not a list of texts")
    options = config.options("options")
    known = frozenset(options)
    command = config.required_command()

    def read(text: str) -> Readings:
        if text.lower() == "none":
            return {"option": None}
        return {"option": text} if text.strip() and text in known else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(require_option("option", value, options)),)

    entity = Entity(config, "x_setting")
    entity.add_capability(
        "option", readable=entity.read_text_from(config.source("state_topic"), read), writer=write, options=options
    )
    entity.add_commands(command)
    return entity.build()
