"""Plain words for what parts say and are told, the same for every convention. Pure.

The words are those of the thesis's topics: ``on``, ``off``, ``open``, ``closed``, ``motion``, ``clear``, ``locked``, a
brightness or a position from ``0`` to ``1``, ``2700 K``, a measured number as text. Whoever understands them needs to
know no convention: a part has a *words address*, on which an endpoint is listened to and told something like on any
other address. It is no legal MQTT topic, so it is never mistaken for one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["main_part", "meaning", "read_words_address", "takes_words", "word", "words_address"]

_SCHEME = "words:"

_FRACTIONS = frozenset({"level", "position", "tilt", "fan_speed", "volume"})
"""Percentages that are spoken as 0 to 1."""

_FIRST = ("lock", "on_off", "occupancy", "contact", "vacuum", "mower", "alarm", "local_temperature")
"""What a message is about when it tells several things; openings, which come next, have a rule of their own."""

_OPENINGS = ("movement", "valve")

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
    if (number := _number(said)) is not None and (told := _told_number(number, settable)) is not None:
        return told
    for name, capability in settable.items():
        if said in capability.options or name == "text":
            return name, said
    raise RefusedError(f"the word {said[:40]!r}", f"this part takes {_known(settable)}")


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
            return name, number * 100
    return None


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _digits(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def _known(settable: Mapping[str, Capability]) -> str:
    words = [said for said, told in _PHRASES.items() if any(name in settable for name, _ in told)]
    words += ["2700 K"] if "color_temperature" in settable else []
    name = next((name for name in _NUMBERS if name in settable), None)
    words += [] if name is None else ["a number from 0 to 1" if name in _FRACTIONS else "a number"]
    words += [option for capability in settable.values() for option in capability.options]
    return ", ".join(dict.fromkeys(words)) or "nothing"
