"""Plain words for what parts say and are told, the same for every convention. Pure.

The words are those of the thesis's topics: ``on``, ``off``, ``open``, ``closed``, ``motion``, ``clear``, ``locked``, a
brightness or a position from ``0`` to ``1``, ``2700 K``, a measured number as text. Whoever understands them needs to
know no convention: a part has a *words address*, on which an endpoint is listened to and told something like on any
other address. It is no legal MQTT topic, so it is never mistaken for one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from homebot.devices.part import Capability, Part
from homebot.devices.text.vocabulary import (
    BOOL_WORDS,
    FRACTION_CAPABILITIES,
    OPENING_WORDS,
    PRIORITY,
    SPEED_WORDS,
    bounds_of,
    percent,
)
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.numbers import to_number

__all__ = [
    "accepts_text",
    "decode_command",
    "encode_command",
    "encode_state",
    "main_part",
]

_PHRASES: Mapping[str, tuple[tuple[str, PlainValue], ...]] = {
    "on": (("on_off", True),),
    "off": (("on_off", False),),
    "open": (("movement", "open"), ("valve", "open"), ("position", 100.0), ("lock", "open")),
    "close": (("movement", "closed"), ("valve", "closed"), ("position", 0.0)),
    "stop": (("movement", "stopped"), ("valve", "stopped")),
    "lock": (("lock", "locked"),),
    "unlock": (("lock", "unlocked"),),
    "press": (("push", True), ("scene", True), ("locate", True)),
}

_NUMBERS = (
    "level",
    "position",
    "fan_speed",
    "heating_setpoint",
    "cooling_setpoint",
    "humidity_setpoint",
    "volume",
    "tilt",
    "number",
)
"""What a bare number is about, the first that the part can be told."""


def main_part(parts: tuple[Part, ...]) -> Part | None:
    """Return the part that a device is there for: the first that is neither setting nor diagnosis, if there is one."""
    for part in parts:
        if not part.category:
            return part
    return parts[0] if parts else None


def accepts_text(part: Part) -> bool:
    """Return whether the part can be told anything."""
    return any(capability.settable for capability in part.capabilities)


def encode_state(readings: Mapping[str, PlainValue]) -> str | None:
    """Return in one word what one message told of a part; None where it told nothing that has a word.

    Args:
        readings: Values by capability.
    """
    for name in PRIORITY:
        if readings.get(name) is not None:
            return _spoken(name, readings[name])
    if (opening := _opening(readings)) is not None:
        return opening
    for name, value in readings.items():
        if (said := _spoken(name, value)) is not None:
            return said
    return None


def decode_command(said: str, part: Part) -> tuple[str, PlainValue]:
    """Return which capability *part* is told to have which value by the word *said*.

    Raises:
        RefusedError: It cannot be told that; names the words that it takes.
    """
    settable = {one.name: one for one in part.capabilities if one.settable}
    for name, value in _PHRASES.get(said, ()):
        if name in settable:
            return name, value
    if said == "off" and (speed := next((name for name in SPEED_WORDS if name in settable), None)) is not None:
        return speed, 0.0
    if said.endswith(" K") and "color_temperature" in settable and (kelvin := to_number(said[:-2])) is not None:
        return "color_temperature", kelvin
    if (number := to_number(said)) is not None and (meant := _told_number(number, settable)) is not None:
        return meant
    for name, capability in settable.items():
        if said in capability.options or name == "text":
            return name, said
    for name, capability in settable.items():
        for option in capability.options:
            if option.casefold() == said:  # such as the OFF of a fan
                return name, option
    raise RefusedError(f"the word {said[:40]!r}", f"this part takes {_known(settable)}")


def encode_command(capability: str, value: PlainValue, part: Part) -> str:
    """Return the word by which *part* is told that *capability* shall be *value*; the inverse of :func:`meaning`.

    Raises:
        RefusedError: It has no word for that; names those that it takes.
    """
    settable = {one.name: one for one in part.capabilities if one.settable}
    if capability in settable and _is_within(value, settable[capability]):
        for said in _candidates(capability, value):
            if _is_understood(said, part, capability, value):
                return said
    raise RefusedError(f"{capability[:40]} {str(value)[:40]}", f"this part takes {_known(settable)}")


def _spoken(name: str, value: PlainValue) -> str | None:
    match value:
        case None | tuple():
            return None
        case bool():
            return BOOL_WORDS.get(name, ("off", "on"))[value]
        case str():
            return value
        case _ if name in FRACTION_CAPABILITIES:
            return _digits(value / 100)
        case _ if name == "color_temperature":
            return f"{_digits(value)} K"
        case _:
            return _digits(value)


def _candidates(capability: str, value: PlainValue) -> Iterator[str]:
    for said, meant in _PHRASES.items():
        if any(name == capability and what == value and type(what) is type(value) for name, what in meant):
            yield said
    spoken = _spoken(capability, value)
    if spoken is not None and not isinstance(value, bool):
        yield spoken


def _is_understood(said: str, part: Part, capability: str, value: PlainValue) -> bool:
    try:
        name, meant = decode_command(said, part)
    except RefusedError:
        return False
    if name != capability:
        return capability in SPEED_WORDS and value == 0 and (name, meant) == ("on_off", False)
    return type(meant) is type(value) and (meant == value or isinstance(value, float))  # rounded to three digits


def _is_within(value: PlainValue, capability: Capability) -> bool:
    low, high = bounds_of(capability)
    return not isinstance(value, float) or low <= value <= high


def _opening(readings: Mapping[str, PlainValue]) -> str | None:
    """On its way it says where to; at rest whether it is closed or open, or its position between the two."""
    movement = next((readings[name] for name in OPENING_WORDS if readings.get(name) is not None), None)
    position = readings.get("position")
    if movement in {"opening", "closing"} or not isinstance(position, float):
        return movement if isinstance(movement, str) else None
    return {0.0: "closed", 100.0: "open"}.get(position) or _digits(position / 100)


def _told_number(number: float, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    for name in _NUMBERS:
        if name in settable:
            if name not in FRACTION_CAPABILITIES:
                return name, number
            if not 0 <= number <= 1:
                return None
            if name == "level" and number == 0 and "on_off" in settable:
                return "on_off", False
            return name, percent(number)
    return None


def _digits(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def _known(settable: Mapping[str, Capability]) -> str:
    words = [said for said, meant in _PHRASES.items() if any(name in settable for name, _ in meant)]
    words += ["2700 K"] if "color_temperature" in settable else []
    name = next((name for name in _NUMBERS if name in settable), None)
    words += [] if name is None else ["a number from 0 to 1" if name in FRACTION_CAPABILITIES else "a number"]
    words += [option for capability in settable.values() for option in capability.options]
    return ", ".join(dict.fromkeys(words)) or "nothing"
