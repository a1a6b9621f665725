"""Checks of a command's value against what the part can do, and writers of commands made of them. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TypeAlias

from homebot.conventions.description import Publications
from homebot.conventions.payload import shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = [
    "Writer",
    "bool_writer",
    "number_writer",
    "option_writer",
    "push_writer",
    "require_bool",
    "require_color",
    "require_number",
    "require_numbers",
    "require_option",
    "require_transition",
]

Writer: TypeAlias = Callable[[PlainValue, float], Publications]
"""The publications for a value and a transition in seconds; raises RefusedError."""

_MOST_NAMED = 20
_HUE_SATURATION = ((0.0, 360.0), (0.0, 100.0))


def require_bool(capability: str, value: PlainValue) -> bool:
    """Return *value* where it is true or false.

    Raises:
        RefusedError: It is something else.
    """
    if isinstance(value, bool):
        return value
    raise RefusedError(f"{capability} {shown(value)}", "it takes true or false")


def require_number(capability: str, value: PlainValue, least: float, most: float, unit: str = "") -> float:
    """Return *value* where it is a number within the bounds.

    Raises:
        RefusedError: It is something else, or outside.
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most:
        return float(value)
    bounds = f"{least:g} to {most:g} {unit}".rstrip()
    raise RefusedError(f"{capability} {shown(value)}", f"it takes a number from {bounds}")


def require_numbers(capability: str, value: PlainValue, bounds: tuple[tuple[float, float], ...]) -> tuple[float, ...]:
    """Return *value* where it has one number within each of the *bounds*.

    Raises:
        RefusedError: It is something else, or one is outside.
    """
    if (
        isinstance(value, tuple)
        and len(value) == len(bounds)
        and all(math.isfinite(one) and least <= one <= most for one, (least, most) in zip(value, bounds, strict=True))
    ):
        return tuple(float(one) for one in value)
    pairs = ", ".join(f"{least:g} to {most:g}" for least, most in bounds)
    raise RefusedError(f"{capability} {shown(value)}", f"it takes numbers from {pairs}")


def require_color(value: PlainValue) -> tuple[float, float]:
    """Return the hue and the saturation that *value* is.

    Raises:
        RefusedError: It is something else, or one is outside 0 to 360 or 0 to 100.
    """
    hue, saturation = require_numbers("color", value, _HUE_SATURATION)
    return hue, saturation


def require_transition(seconds: float, most: float = math.inf) -> float:
    """Return *seconds* where a change can take so long.

    Raises:
        RefusedError: They are none, or more than *most*.
    """
    if math.isfinite(seconds) and 0 <= seconds <= most:
        return seconds
    takes = "0 or more seconds" if math.isinf(most) else f"0 to {most:g} s"
    raise RefusedError(f"a transition of {seconds:g} s", f"it takes {takes}")


def require_option(capability: str, value: PlainValue, options: Iterable[str]) -> str:
    """Return *value* where it is one of the *options*.

    Raises:
        RefusedError: It is none of them; names them.
    """
    known = tuple(options)
    if isinstance(value, str) and value in known:
        return value
    named = ", ".join(known[:_MOST_NAMED]) + (", …" if len(known) > _MOST_NAMED else "")
    raise RefusedError(f"{capability} {shown(value)}", f"it takes {named}" if known else "it takes none")


def bool_writer(capability: str, publish: Callable[[bool], Publications]) -> Writer:
    """Return a writer of true and false without transition."""
    return lambda value, _transition: publish(require_bool(capability, value))


def number_writer(
    capability: str, bounds: tuple[float, ...], unit: str, publish: Callable[[float], Publications]
) -> Writer:
    """Return a writer of numbers within the *bounds*, a smallest and a largest, without transition."""
    least, most = bounds
    return lambda value, _transition: publish(require_number(capability, value, least, most, unit))


def option_writer(capability: str, options: Iterable[str], publish: Callable[[str], Publications]) -> Writer:
    """Return a writer of one of the *options* without transition."""
    return lambda value, _transition: publish(require_option(capability, value, options))


def push_writer(capability: str, publish: Callable[[], Publications]) -> Writer:
    """Return a writer of true alone: the part does something, and keeps no state."""

    def write(value: PlainValue, _transition: float) -> Publications:
        if value is not True:
            raise RefusedError(f"{capability} {shown(value)}", "it takes only true")
        return publish()

    return write
