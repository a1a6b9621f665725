"""Settings from the words of a command, such as ``on`` with ``level`` 40, for one part. Pure."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from types import MappingProxyType
from typing import Final

from homebot.devices import KeyValue
from homebot.devices.capabilities import CAPABILITIES, OWN, settable_options
from homebot.devices.part import Capability, Part, accepted_values, check_no_share, check_setting
from homebot.devices.text.commands import decode_command
from homebot.devices.text.states import is_share
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import changes, related
from homebot.errors import RefusedError, UsageError
from homebot.support.numbers import to_number
from homebot.words.amounts import FLAGS, read_amount, read_change, split_commands
from homebot.words.colors import COLORS, WHITES
from homebot.words.tokens import MAX_QUERY, has_code

SET: Final = "set"
"""The command that only sets values."""

_SAME_WORDS: Final[Mapping[str, str]] = MappingProxyType(
    {"on": "on", "turn_on": "on", "turn on": "on", "turn_off": "off", "turn off": "off", SET: SET}
)
STATE_WORDS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "start": ("cleaning", "mowing"),
        "pause": ("paused",),
        "stop": ("idle",),
        "dock": ("returning", "docked"),
        "heat": ("heat",),
        "heating": ("heat",),
        "cool": ("cool",),
        "cooling": ("cool",),
        "disarm": ("disarmed",),
        "arm": ("armed_away",),
        **{f"arm {mode}": (f"armed_{mode}",) for mode in ("away", "home", "night", "vacation")},
    }
)
"""States of vacuum cleaners, mowers, thermostats and alarms for a word; each device takes one of them."""


def parse_command_words(
    command: str,
    values: Sequence[KeyValue],
    part: Part,
    target: str,
    known: Mapping[str, PlainValue] = MappingProxyType({}),
) -> dict[str, PlainValue]:
    """Return the values by capability that a command sets on *part*.

    Args:
        command: A word that the part takes, such as ``on``, ``close``, ``0.4``, ``40 %``, ``+10 %`` or ``2700 K``, or a
            capability and its value, such as ``level 40``; :data:`SET` for none. Case does not matter.
        values: Further values by capability, as text: ``level`` is ``40``.
        known: The certain values of the part, which ``+10 %`` and ``darker`` change.

    Raises:
        RefusedError: The part does not take the word, capability or value, or there is none; the message names those
            that it takes. They contradict each other, such as ``off`` with a level of 50, or change an unknown value.
    """
    if max(map(len, (command, *(text for value in values for text in (value.key, value.value))))) > MAX_QUERY:
        raise RefusedError(f"a command to {target}", f"it is longer than {MAX_QUERY:,} characters")
    words = _several(command.strip(), part)
    settings: dict[str, PlainValue] = {}
    is_more = len(words) + len(values) > 1 and "on" in words and "off" not in words
    is_light_on = is_more and part.service_type == "light"  # a level turns a lamp on
    for word in words:
        if word == SET or (is_light_on and word == "on"):
            continue
        capability, value = _read_change(word, part, target, known) or _decode(word, part, target)
        if settings.setdefault(capability, value) != value:
            raise RefusedError(_command_text(command, values), "these contradict each other; give one of them")
    settings.update(_further_setting(value, part, target, known) for value in values)
    for capability, value in settings.items():
        check_setting(target, part, capability, value)
    if not settings:
        raise RefusedError(f"{SET} without values", "give one, such as level 40")
    if not _agree({"on_off": True, **settings} if is_light_on else settings, part):
        raise RefusedError(_command_text(command, values), "these contradict each other; give one of them")
    return settings


def is_relative(command: str) -> bool:
    """Return whether *command* changes a value, so that it does more when it is given twice."""
    return read_change(command) is not None


def _further_setting(
    given: KeyValue, part: Part, target: str, known: Mapping[str, PlainValue]
) -> tuple[str, PlainValue]:
    """Return the setting *given* beside the command; its name may end in its value, as in ``heating = setpoint 21``."""
    text, count = f"{given.key} {given.value}", len(given.key.split()) + 1
    longer = _read_change(text, part, target, known) or _named_value(text, part, target, count)
    return longer or _setting(given.key, given.value, part, target)


def _read_change(given: str, part: Part, target: str, known: Mapping[str, PlainValue]) -> tuple[str, PlainValue] | None:
    """Return the setting that a change such as ``+10 %``, ``level -5`` or ``darker`` leads to; None if it is none.

    A minus is part of the number for what may be below zero. No lamp is turned off by getting darker.
    """
    if (change := read_change(given)) is None:
        return None
    name, amount = _decode(f"{change.before}{change.amount}", part, target)
    low, high = _bounds(name, part.capabilities)
    if change.sign == "-" and (low < 0 or not isinstance(amount, float)):
        return None
    if not isinstance(amount, float):
        raise RefusedError(f"{given} of {target}", f"it takes {accepted_values(part, name) or name}, and no change")
    is_off = name == "level" and known.get("on_off") is False
    before = 0.0 if is_off else known.get(name)
    if not isinstance(before, float):
        problem = f"by {change.amount}? Its {name} is unknown; give a value, such as {change.amount}"
        raise RefusedError(f"{given} of {target}", problem)
    if change.sign == "-":
        return name, 0.0 if is_off else max(1.0 if name == "level" else low, before - amount)
    return name, min(high, before + amount)


def check_without_code(words: str) -> None:
    """Check that *words* that are kept contain no code.

    Raises:
        UsageError: They do.
    """
    if has_code(words):
        raise UsageError("no code is kept, as everyone who may read this would see it; leave it out")


def _several(command: str, part: Part) -> list[str]:
    """Return the words of ``on, 40 %``; of a text of the part's own, with its commas, only that."""
    if "," not in command or any(command in one.options for one in part.capabilities):
        return [_SAME_WORDS.get(command.casefold(), command)]
    return [_SAME_WORDS.get(word.casefold(), word) for word in split_commands(command)]


def _command_text(command: str, values: Sequence[KeyValue]) -> str:
    return " with ".join(filter(None, (command, ", ".join(f"{one.key} {one.value}" for one in values))))


def _agree(settings: Mapping[str, PlainValue], part: Part) -> bool:
    """Return whether none of *settings* would undo another; setting a colour turns most lamps on."""
    if part.service_type == "light" and settings.get("on_off") is False and len(settings) > 1:
        return all(name == "level" and value == 0 for name, value in settings.items() if name != "on_off")
    pairs = combinations(settings.items(), 2)
    return not any(
        other in related(one) and changes(one, value, other, second) for (one, value), (other, second) in pairs
    )


def _capability(word: str, part: Part) -> str:
    settable = {one.name for one in part.capabilities if one.settable}
    meant = [name for name, known in CAPABILITIES.items() if known.spoken and known.spoken == word]
    return next((name for name in meant if name in settable), word.replace(" ", "_"))


def _decode(given: str, part: Part, target: str) -> tuple[str, PlainValue]:
    word = given.casefold()
    try:
        return decode_command(given, part)
    except RefusedError as exc:
        if (found := _read_synonym(given, part, target)) is not None:
            return found
        if to_number(word) is not None and _respelt(f"{word}%", part) is not None:
            raise RefusedError(exc.what, f"{exc.reason}; did you mean {word} %?") from None
        capability = _capability(word, part)
        accepted = accepted_values(part, capability)
        if not accepted:
            raise
        if "press" in CAPABILITIES.get(capability, OWN).words:  # it can only be set to true
            return capability, True
        raise RefusedError(f"{word} without a value", f"it takes {accepted}") from None


def _read_synonym(given: str, part: Part, target: str) -> tuple[str, PlainValue] | None:
    """Return the setting for a word that no text of the part is; None for none."""
    word = given.casefold()
    return (
        _respelt(word, part)
        or _with_unit(word, part)
        or _named_value(given, part, target)
        or _state_for(word, part)
        or _read_color(word, part)
    )


def _state_for(word: str, part: Part) -> tuple[str, PlainValue] | None:
    """Return the setting of a robot, alarm or lock for a word, or a press of the button of that name; None for none."""
    states = (*STATE_WORDS.get(word.replace("_", " "), ()), word.replace(" ", "_"))
    for one in part.capabilities:
        if one.settable and CAPABILITIES.get(one.name, OWN).by_state:
            options = settable_options(one.name, one.options or CAPABILITIES[one.name].options)
            if (state := next((state for state in states if state in options), None)) is not None:
                return one.name, state
        elif one.settable and one.name == "push" and word == part.name.casefold():
            return one.name, True
    return None


def _read_color(word: str, part: Part) -> tuple[str, PlainValue] | None:
    """Return the setting for the name of a colour, or of a white tone, that *part* takes; None for none."""
    name = word.replace("_", " ")
    named = {"color_temperature": WHITES.get(name), "color": COLORS.get(name)}
    settable = [one.name for one in part.capabilities if one.settable]
    return next(((capability, value) for capability, value in named.items() if value and capability in settable), None)


def _named_value(text: str, part: Part, target: str, least: int = 1) -> tuple[str, PlainValue] | None:
    """Return the setting that ``level 40`` or ``set fan speed to 40`` names, by the longest name of *part* that fits.

    Args:
        least: The least number of words of the name.
    """
    words = text.split(" ")
    words = words[words[0].casefold() == SET :]
    for count in range(len(words) - 1, least - 1, -1):
        name, rest = " ".join(words[:count]).casefold(), words[count:]
        value = " ".join(rest[len(rest) > 1 and rest[0].casefold() == "to" :])
        is_settable = any(one.name == _capability(name, part) and one.settable for one in part.capabilities)
        if is_settable or (name == "color" and _read_color(value, part) is not None):
            return _setting(name, value, part, target)
    return None


def _respelt(word: str, part: Part) -> tuple[str, PlainValue] | None:
    """Return the setting for another spelling of a word: in lower case, ``2700k`` or ``40 %``."""
    amount, percentage, spelling = read_amount(word), None, word
    if amount is not None and amount.unit.casefold() == "k":
        spelling = f"{amount.number} K"
    elif amount is not None and amount.unit == "%":
        percentage = float(amount.number)
        spelling = f"{percentage / 100:g}"
    try:
        capability, value = decode_command(spelling, part)
    except RefusedError:
        return None
    is_fraction = is_share(capability) or capability == "on_off"  # 0 turns off a part with a switch
    return (capability, value) if percentage is None or is_fraction else None


def _with_unit(word: str, part: Part) -> tuple[str, PlainValue] | None:
    """Return the setting for a number with its unit, such as ``21 °C``, if a bare number sets it on *part*."""
    amount = read_amount(word)
    if amount is None or not amount.unit:
        return None
    try:
        capability, value = decode_command(amount.number, part)
    except RefusedError:
        return None
    is_whole = not is_share(capability) and capability != "on_off"
    return (capability, value) if is_whole and _is_unit(amount.unit, _unit(capability, part.capabilities)) else None


def _is_unit(text: str, unit: str) -> bool:
    """Return whether *text* spells *unit*, in any case and with or without the degree sign."""
    return text.casefold().removeprefix("°") == unit.casefold().removeprefix("°") != ""


def _setting(word: str, text: str, part: Part, target: str) -> tuple[str, PlainValue]:
    """Return the setting of a capability by *word*: a white tone as a colour is a colour temperature where it can."""
    if word == "color" and (colored := _read_color(text.casefold(), part)) is not None:
        return colored
    name = _capability(word, part)
    return name, _value(name, text, part, target)


def _value(name: str, text: str, part: Part, target: str) -> PlainValue:
    kind = CAPABILITIES.get(name, OWN).kind
    plain = text.strip()
    if kind == "bool":
        flag = FLAGS.get(plain.casefold())
        if flag is None:
            raise RefusedError(f"{plain[:40]!r} as {name} of {target}", "it takes on or off")
        return flag
    if name == "color_temperature" and (kelvin := WHITES.get(plain.casefold().replace("_", " "))) is not None:
        return kelvin
    if kind == "number":
        return _number(name, plain, part, target)
    if kind == "numbers":
        return _color(plain)
    options = next((one.options for one in part.capabilities if one.name == name), ())
    return next((one for one in options if one.casefold() == plain.casefold()), plain)


def _color(text: str) -> PlainValue:
    """Return the hue and the saturation, or *text* if it is not a colour, which :func:`check_setting` refuses."""
    if (named := COLORS.get(text.casefold().replace("_", " "))) is not None:
        return named
    match [to_number(one) for one in text.replace(",", " ").split()]:
        case [float() as hue, float() as saturation]:
            return hue, saturation
    return text


def _number(name: str, text: str, part: Part, target: str) -> float:
    amount, unit = read_amount(text), _unit(name, part.capabilities)
    if amount is None or (amount.unit and not _is_unit(amount.unit, unit)):
        accepted = f"it takes a number in {unit}" if unit else "it takes a number"
        raise RefusedError(f"{text[:40]!r} as {name} of {target}", accepted)
    number = float(amount.number)
    if not amount.unit:
        check_no_share(target, name, number, f"{name} {text} %")
    return number


def _unit(name: str, capabilities: Iterable[Capability]) -> str:
    own = next((capability.unit for capability in capabilities if capability.name == name and capability.unit), "")
    return own or CAPABILITIES.get(name, OWN).unit


def _bounds(name: str, capabilities: Iterable[Capability]) -> tuple[float, float]:
    own = next((capability.bounds for capability in capabilities if capability.name == name), ())
    low, high = own or CAPABILITIES.get(name, OWN).bounds or (-math.inf, math.inf)
    return low, high
