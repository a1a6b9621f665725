"""Commands for a level of 0, which turn a part off. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.devices.command_messages import Setting
from homebot.devices.part import Part
from homebot.devices.value import PlainValue

__all__ = ["held_zero_as_off", "zero_as_off"]

_LEVELS: Final = ("level", "fan_speed")


def zero_as_off(settings: Mapping[str, PlainValue], part: Part) -> Mapping[str, PlainValue]:
    """Return *settings* with ``on_off`` false in place of a level or a speed of 0, where *part* takes that.

    Most lamps that are off report the brightness that they will have, so that they would never report a level of 0.
    """
    if settings.get("level") != 0.0 and settings.get("fan_speed") != 0.0:
        return settings  # as nearly always
    if not any(one.name == "on_off" and one.settable for one in part.capabilities):
        return settings
    others = {name: value for name, value in settings.items() if name not in _LEVELS or value != 0.0}
    return {**others, "on_off": False}  # at last, as to set a colour turns most lamps on


def held_zero_as_off(setting: Setting, part: Part) -> Setting:
    """Return *setting*, in the same way."""
    ((capability, value),) = zero_as_off({setting.capability: setting.value.plain()}, part).items()
    return Setting.of(capability, value)
