"""The capabilities that are set to obey a command. Pure."""

from __future__ import annotations

from collections.abc import Container
from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["writes_of"]

_OF_LIGHT: Final = frozenset({"level", "color", "color_temperature", "effect"})


def writes_of(capability: str, value: PlainValue, settable: Container[str]) -> tuple[tuple[str, PlainValue], ...]:
    """Return what is set, in this order, so that *capability* of a part is *value*; *settable* is what the part has.

    Setting the brightness or the colour of a lamp also switches it on, because Thing Descriptions leave that to who
    asks. Brightness 0 switches it off.
    """
    if capability not in _OF_LIGHT or "on_off" not in settable:
        return ((capability, value),)
    if capability == "level" and value == 0:
        return (("on_off", False),)
    return ((capability, value), ("on_off", True))
