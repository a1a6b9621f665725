"""Text form of commands, the same for every convention. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from operator import attrgetter

from homebot.devices.capabilities import CAPABILITIES, OWN, settable_options
from homebot.devices.part import Capability, Part
from homebot.devices.text.states import FRACTION_CAPABILITIES, SPEED_WORDS, bounds_of, encode_value, percent
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.support.numbers import to_number

__all__ = ["accepts_text", "decode_command", "encode_command", "main_part"]


_PHRASES: Mapping[str, tuple[tuple[str, PlainValue], ...]] = {
    "on": (("on_off", True),),
    "off": (("on_off", False),),
    "open": (("movement", "open"), ("valve", "open"), ("position", 100.0), ("tilt", 100.0), ("lock", "open")),
    "close": (("movement", "closed"), ("valve", "closed"), ("position", 0.0), ("tilt", 0.0)),
    "stop": (("movement", "stopped"), ("valve", "stopped"), ("playback", "stopped")),
    "play": (("playback", "playing"),),
    "pause": (("playback", "paused"),),
    "mute": (("muted", True),),
    "unmute": (("muted", False),),
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
)
"""The capabilities that a bare number sets before others; it sets the first that the part has."""


def main_part(parts: tuple[Part, ...]) -> Part | None:
    """Return the part that a device is there for: the first that is neither setting nor diagnosis, if there is one."""
    for part in parts:
        if not part.category:
            return part
    return parts[0] if parts else None


_SETTABLE = attrgetter("settable")


def accepts_text(part: Part) -> bool:
    """Return whether the part takes commands."""
    return any(map(_SETTABLE, part.capabilities))


def decode_command(text: str, part: Part) -> tuple[str, PlainValue]:
    """Return the capability of *part*, and the value for it, that *text* sets.

    Raises:
        RefusedError: It does not take this text; the message names those that it takes.
    """
    settable = {one.name: one for one in part.capabilities if one.settable}
    command = (
        _phrase_command(text, settable)
        or _kelvin_command(text, settable)
        or _number_command(text, settable)
        or _option_command(text, settable)
    )
    if command is None:
        taken = f"this part takes {_known(settable)}" if settable else "it takes no commands, it only reports"
        raise RefusedError(f"the word {text[:40]!r}", taken)
    return command


def _phrase_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    for name, value in _PHRASES.get(text, ()):
        if name in settable:
            return name, value
    speed = next((name for name in SPEED_WORDS if name in settable), None)
    return (speed, 0.0) if text == "off" and speed is not None else None


def _option_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    for name, capability in settable.items():
        if text in settable_options(name, capability.options) or name == "text":
            return name, text
    for name, capability in settable.items():
        for option in settable_options(name, capability.options):
            if option.casefold() == text:  # such as the OFF of a fan
                return name, option
    return None


def encode_command(capability: str, value: PlainValue, part: Part) -> str:
    """Return the text that sets *capability* of *part* to *value*; the reverse of :func:`decode_command`.

    Raises:
        RefusedError: There is none; the message names the texts that the part takes.
    """
    settable = {one.name: one for one in part.capabilities if one.settable}
    if capability in settable and _is_within(value, settable[capability]):
        for text in _candidates(capability, value):
            if _is_decoded(text, part, capability, value):
                return text
    raise RefusedError(f"{capability[:40]} {str(value)[:40]}", f"this part takes {_known(settable)}")


def _candidates(capability: str, value: PlainValue) -> Iterator[str]:
    for text, command in _PHRASES.items():
        if any(name == capability and wanted == value and type(wanted) is type(value) for name, wanted in command):
            yield text
    own = encode_value(capability, value)
    if own is not None and not isinstance(value, bool):
        yield own


def _is_decoded(text: str, part: Part, capability: str, value: PlainValue) -> bool:
    try:
        name, decoded = decode_command(text, part)
    except RefusedError:
        return False
    if name != capability:
        return capability in SPEED_WORDS and value == 0 and (name, decoded) == ("on_off", False)
    return type(decoded) is type(value) and (decoded == value or isinstance(value, float))  # rounded to three digits


def _is_within(value: PlainValue, capability: Capability) -> bool:
    low, high = bounds_of(capability)
    return not isinstance(value, float) or low <= value <= high


def _kelvin_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    if text.endswith(" K") and "color_temperature" in settable and (kelvin := to_number(text[:-2])) is not None:
        return "color_temperature", kelvin
    return None


def _number_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    number = to_number(text)
    name = _number_in(settable)
    if number is None or name is None:
        return None
    if name not in FRACTION_CAPABILITIES:
        return name, number
    if not 0 <= number <= 1:
        return None
    if name == "level" and number == 0 and "on_off" in settable:
        return "on_off", False
    return name, percent(number)


def _number_in(settable: Mapping[str, Capability]) -> str | None:
    numbers = [one for one in settable if one != "color_temperature" and CAPABILITIES.get(one, OWN).kind == "number"]
    return next((one for one in (*_NUMBERS, *numbers) if one in numbers), None)


def _known(settable: Mapping[str, Capability]) -> str:
    words = [text for text, command in _PHRASES.items() if any(name in settable for name, _ in command)]
    if not settable.keys().isdisjoint(SPEED_WORDS):
        words.append("off")
    words += ["2700 K"] if "color_temperature" in settable else []
    if (name := _number_in(settable)) is not None:
        words.append("a number from 0 to 1 (0.4 for 40 %)" if name in FRACTION_CAPABILITIES else "a number")
    words += [option for name, one in settable.items() for option in settable_options(name, one.options)]
    return ", ".join(dict.fromkeys(words)) or "nothing"
