"""The components ``text`` and ``notify``: a setting, or a message, that is a text. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/text.py`` and ``notify.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings, clean_text
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

__all__ = ["build_notify", "build_text"]


def build_text(config: DiscoveryConfig) -> DescribedPart:
    """Describe a text. A password is sent, but never read.

    Of the config's ``pattern`` nothing is checked: it is a stranger's regular expression, and the device has its own.
    """
    least = config.integer("min", 0, least=0)
    most = config.integer("max", _LONGEST, least=0, most=_LONGEST)
    if least > most:
        raise WireError(f"text: max is {most}, below min {least}")
    is_secret = config.text("mode", "text") == "password"

    def read(text: str) -> Readings:
        if text == "None":
            return {"text": None}
        return NO_READINGS if len(text) > _LONGEST else {"text": clean_text(text, _LONGEST)}

    return _build_setting(config, least, most, None if is_secret else read)


def build_notify(config: DiscoveryConfig) -> DescribedPart:
    """Describe something that shows or reads out messages."""
    return _build_setting(config, 0, _LONGEST_MESSAGE, None)


_Read: TypeAlias = Callable[[str], Readings]
_LONGEST = 255
_LONGEST_MESSAGE = 4096


def _build_setting(config: DiscoveryConfig, least: int, most: int, read: _Read | None) -> DescribedPart:
    command = config.required_command()

    def write(value: PlainValue, _transition: float) -> Publications:
        if not isinstance(value, str) or not least <= len(value) <= most:
            raise RefusedError("text", f"it takes a text of {least} to {most} characters")
        return command.publish(value)

    entity = Entity(config, "x_setting")
    is_readable = read is not None and entity.read_text_from(config.source("state_topic"), read)
    entity.add_capability("text", readable=is_readable, writer=write)
    entity.add_commands(command)
    return entity.build()
