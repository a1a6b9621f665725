"""Effect that a command has outside the device, for sensors to see: what becomes stronger or weaker. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["ACTING", "SENSED", "Effect", "looks_of", "seen_by", "strength_of"]

SENSED: Final = frozenset({"illuminance", "power", "contact", "unlocked", "flow"})
"""Capabilities of sensors that may see an effect within seconds.

Motion and temperature are none of them: people move by themselves, and rooms warm more slowly than commands wait.
"""

_SEEN_BY: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "on_off": ("illuminance", "power"),
        "level": ("illuminance", "power"),
        "fan_speed": ("power",),
        "position": ("contact",),
        "movement": ("contact",),
        "lock": ("unlocked",),
        "valve": ("flow",),
    }
)

ACTING: Final = frozenset({*_SEEN_BY, "color", "color_temperature", "effect", "tilt", "thermostat_action", "contact"})
"""Capabilities whose changes may change what sensors measure."""

_FULL: Final = 100.0
_ENDS: Final[Mapping[PlainValue, float]] = MappingProxyType(
    {"open": _FULL, "closed": 0.0, "unlocked": _FULL, "locked": 0.0}
)
_HUE_STEP: Final = 30.0  # degrees
_SATURATION_STEP: Final = 25.0  # percent


@dataclass(frozen=True, slots=True)
class Effect:
    """Change of the strength of a part.

    Attributes:
        rises: Whether it becomes stronger: on, brighter, open, unlocked.
        size: By how much of its full strength, 0 to 100.
        looks: Its colour and effect, roughly: a blue lamp gives less light than a white one.
    """

    rises: bool
    size: float
    looks: str = ""


def seen_by(settings: Iterable[str]) -> frozenset[str]:
    """Return the capabilities of sensors that may see a change of one of *settings*."""
    return frozenset(sensed for one in settings for sensed in _SEEN_BY.get(one, ()))


def strength_of(values: Mapping[str, PlainValue], reported: Collection[str]) -> float | None:
    """Return how strong a part is that reports *values*, 0 to 100; None where that is unknown.

    Args:
        values: The values by capability, each reported or commanded.
        reported: All that the part ever reported; one that told a level and does not now is of unknown strength.
    """
    if values.get("on_off") is False:
        return 0.0
    for name in ("level", "fan_speed", "position"):
        if name in reported or name in values:
            value = values.get(name)
            return value if isinstance(value, float) else None
    if values.get("on_off") is True:
        return _FULL
    return next((_ENDS[values[one]] for one in ("movement", "lock", "valve") if values.get(one) in _ENDS), None)


def looks_of(values: Mapping[str, PlainValue]) -> str:
    """Return the colour and the effect in *values*, roughly."""
    color, effect = values.get("color"), values.get("effect")
    text = effect.casefold() if isinstance(effect, str) else ""
    if isinstance(color, tuple) and len(color) == 2 and color[1] >= _SATURATION_STEP / 2:
        text += f" {round(color[0] / _HUE_STEP)}/{round(color[1] / _SATURATION_STEP)}"
    return text
