"""The orders that a simulated lamp was given: ``on``, ``off``, ``0.4`` for a brightness, and ``2700 K``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["SETTINGS", "is_told_on", "value_told"]

SETTINGS: Final[Mapping[str, PlainValue]] = {"level": 40.0, "color_temperature": 2700.0}


def is_told_on(orders: Sequence[str]) -> bool | None:
    """Whether the last order that turns it on or off, as a brightness does, turned it on; None without any."""
    switching = [one for one in orders if not one.endswith(" K")]
    return switching[-1] not in {"off", "0"} if switching else None


def value_told(orders: Sequence[str], capability: str) -> PlainValue:
    """The last value that it was told for a capability, in the unit of the vocabulary."""
    if capability == "color_temperature":
        told = [float(one.removesuffix(" K")) for one in orders if one.endswith(" K")]
    else:
        told = [100 * float(one) for one in orders if one[0].isdigit() and not one.endswith(" K")]
    return told[-1] if told else None
