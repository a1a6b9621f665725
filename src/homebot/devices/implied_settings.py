"""The settings that a command for one capability stands for. Pure."""

from __future__ import annotations

from collections.abc import Container
from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["LIGHTS_UP", "implied_settings"]

LIGHTS_UP: Final = frozenset({"level", "color", "color_temperature", "effect"})
"""Capabilities of a light by which it is turned on."""


def implied_settings(
    capability: str, value: PlainValue, settable: Container[str]
) -> tuple[tuple[str, PlainValue], ...]:
    """Return the settings, in this order, that make *capability* *value* and turn a light on, or off at level 0.

    A gateway calls it for protocols in which the brightness or the colour of a light that is off leaves it off.

    Args:
        capability: The capability of the command.
        value: The value of the command.
        settable: The capabilities that the part takes.
    """
    if capability not in LIGHTS_UP or "on_off" not in settable:
        return ((capability, value),)
    if capability == "level" and value == 0:
        return (("on_off", False),)
    return ((capability, value), ("on_off", True))
