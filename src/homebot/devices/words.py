"""Plain words for what parts say and are told, the same for every convention. Pure.

The words are those of the thesis's topics: ``on``, ``off``, ``open``, ``closed``, ``motion``, ``clear``, ``locked``, a
brightness or a position from ``0`` to ``1``, ``2700 K``, a measured number as text. Whoever understands them needs to
know no convention: a part has a *words address*, on which an endpoint is listened to and told something like on any
other address. It is no legal MQTT topic, so it is never mistaken for one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["heard", "main_part", "meaning", "read_words_address", "takes_words", "told", "word", "words_address"]

_SCHEME = "words:"

_FRACTIONS = frozenset({"level", "position", "tilt", "fan_speed", "volume"})
"""Percentages that are spoken as 0 to 1."""

_FIRST = ("lock", "on_off", "occupancy", "contact", "vacuum", "mower", "alarm", "local_temperature")
"""What a message is about when it tells several things; openings, which come next, have a rule of their own."""

_OPENINGS = ("movement", "valve")

_SPEEDS = frozenset({"level", "fan_speed"})
"""What is 0 only where it is off."""

_LONGEST = 255
"""Characters of a word that may be any text."""

_FLAGS: Mapping[str, tuple[str, str]] = {"occupancy": ("clear", "motion"), "contact": ("closed", "open")}

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


def words_address(key: str, part_id: str) -> str:
    """Return where the part *part_id* of the device that its gateway calls *key* speaks plain words."""
    return f"{_SCHEME}{_escape(key)}#{_escape(part_id)}"


def read_words_address(address: str) -> tuple[str, str] | None:
    """Return key and part of a words address; None for any other address."""
    if not address.startswith(_SCHEME):
        return None
    key, mark, part_id = address[len(_SCHEME) :].partition("#")
    return (_unescape(key), _unescape(part_id)) if mark and "#" not in part_id else None


def main_part(parts: tuple[Part, ...]) -> Part | None:
    """Return the part that a device is there for: the first that is neither setting nor diagnosis, if there is one."""
    for part in parts:
        if not part.category:
            return part
    return parts[0] if parts else None


def takes_words(part: Part) -> bool:
    """Whether the part can be told anything."""
    return any(capability.settable for capability in part.capabilities)


def word(readings: Mapping[str, PlainValue]) -> str | None:
    """Return in one word what one message told of a part; None where it told nothing that has a word.

    Args:
        readings: Values by capability.
    """
    for name in _FIRST:
        if readings.get(name) is not None:
            return _spoken(name, readings[name])
    if (opening := _opening(readings)) is not None:
        return opening
    for name, value in readings.items():
        if (said := _spoken(name, value)) is not None:
            return said
    return None


def meaning(said: str, part: Part) -> tuple[str, PlainValue]:
    """Return which capability *part* is told to have which value by the word *said*.

    Raises:
        RefusedError: It cannot be told that; names the words that it takes.
    """
    settable = {one.name: one for one in part.capabilities if one.settable}
    for name, value in _PHRASES.get(said, ()):
        if name in settable:
            return name, value
    if said.endswith(" K") and "color_temperature" in settable and (kelvin := _number(said[:-2])) is not None:
        return "color_temperature", kelvin
    if (number := _number(said)) is not None and (meant := _told_number(number, settable)) is not None:
        return meant
    for name, capability in settable.items():
        if said in capability.options or name == "text":
            return name, said
    raise RefusedError(f"the word {said[:40]!r}", f"this part takes {_known(settable)}")


def heard(said: str, part: Part) -> dict[str, PlainValue]:
    """Return what the word *said* tells of *part*, by capability; empty where it is none of its words.

    The inverse of :func:`word`, with what follows from it: a lamp that says ``0.4`` is on, and what says ``closed`` is
    at 0 %. Of several capabilities that a bare number may be about it is the one that :func:`word` speaks of first.
    """
    readable = {one.name: one for one in part.capabilities if one.readable}
    for name in dict.fromkeys((*(one for one in (*_FIRST, *_OPENINGS) if one in readable), *readable)):
        value = _understood(said, readable[name])
        if value is not None:
            implied = ((other, what) for other, what in _implied(name, value) if other in readable)
            return {name: value, **dict(implied)}
    return {}


def told(capability: str, value: PlainValue, part: Part) -> str:
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


def _escape(text: str) -> str:
    return text.replace("%", "%25").replace("#", "%23")


def _unescape(text: str) -> str:
    return text.replace("%23", "#").replace("%25", "%")


def _spoken(name: str, value: PlainValue) -> str | None:
    match value:
        case None | tuple():
            return None
        case bool():
            return _FLAGS.get(name, ("off", "on"))[value]
        case str():
            return value
        case _ if name in _FRACTIONS:
            return _digits(value / 100)
        case _ if name == "color_temperature":
            return f"{_digits(value)} K"
        case _:
            return _digits(value)


def _understood(said: str, capability: Capability) -> PlainValue:
    known = CAPABILITIES.get(capability.name)
    match known.kind if known else "":
        case "bool":
            no, yes = _FLAGS.get(capability.name, ("off", "on"))
            return {no: False, yes: True}.get(said)
        case "text":
            options = capability.options or (known.options if known else ())
            return said if said in options or (not options and 0 < len(said) <= _LONGEST) else None
        case "number":
            is_kelvin = capability.name == "color_temperature"
            number = _number(said.removesuffix(" K")) if is_kelvin == said.endswith(" K") else None
            if number is not None and capability.name in _FRACTIONS:
                number = _percent(number)
            return number if _is_within(number, capability) else None
        case _:
            return None


def _implied(name: str, value: PlainValue) -> Iterator[tuple[str, PlainValue]]:
    if name in _SPEEDS and isinstance(value, float):
        yield "on_off", value > 0
    if name == "position" and isinstance(value, float):
        movement = {0.0: "closed", 100.0: "open"}.get(value, "stopped")
        yield from ((one, movement) for one in _OPENINGS)
    if name in _OPENINGS and value in {"open", "closed"}:
        yield "position", 100.0 if value == "open" else 0.0


def _candidates(capability: str, value: PlainValue) -> Iterator[str]:
    for said, meant in _PHRASES.items():
        if any(name == capability and what == value and type(what) is type(value) for name, what in meant):
            yield said
    spoken = _spoken(capability, value)
    if spoken is not None and not isinstance(value, bool):
        yield spoken


def _is_understood(said: str, part: Part, capability: str, value: PlainValue) -> bool:
    try:
        name, meant = meaning(said, part)
    except RefusedError:
        return False
    if name != capability:
        return capability in _SPEEDS and value == 0 and (name, meant) == ("on_off", False)
    return type(meant) is type(value) and (meant == value or isinstance(value, float))  # rounded to three digits


def _is_within(value: PlainValue, capability: Capability) -> bool:
    """Whether *value* is within the bounds, where it is a number and has some."""
    known = CAPABILITIES.get(capability.name)
    bounds = capability.bounds or (known.bounds if known else ())
    return not isinstance(value, float) or not bounds or bounds[0] <= value <= bounds[-1]


def _opening(readings: Mapping[str, PlainValue]) -> str | None:
    """On its way it says where to; at rest whether it is closed or open, or its position between the two."""
    movement = next((readings[name] for name in _OPENINGS if readings.get(name) is not None), None)
    position = readings.get("position")
    if movement in {"opening", "closing"} or not isinstance(position, float):
        return movement if isinstance(movement, str) else None
    return {0.0: "closed", 100.0: "open"}.get(position) or _digits(position / 100)


def _told_number(number: float, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    for name in _NUMBERS:
        if name in settable:
            if name not in _FRACTIONS:
                return name, number
            if not 0 <= number <= 1:
                return None
            if name == "level" and number == 0 and "on_off" in settable:
                return "on_off", False
            return name, _percent(number)
    return None


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _percent(share: float) -> float:
    return round(share * 100, 9)  # 0.07 is 7 %, not 7.000000000000001


def _digits(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def _known(settable: Mapping[str, Capability]) -> str:
    words = [said for said, meant in _PHRASES.items() if any(name in settable for name, _ in meant)]
    words += ["2700 K"] if "color_temperature" in settable else []
    name = next((name for name in _NUMBERS if name in settable), None)
    words += [] if name is None else ["a number from 0 to 1" if name in _FRACTIONS else "a number"]
    words += [option for capability in settable.values() for option in capability.options]
    return ", ".join(dict.fromkeys(words)) or "nothing"
