"""The values of a part in the words of ``homebot do``, such as ``on, 20 %, 2700 K``. Pure."""

from collections.abc import Iterable
from typing import Final

from homebot.command_words.undo_record import RESTORED
from homebot.control.journal.given_codes import without_codes
from homebot.devices import Device, DevicePart, KeyValue
from homebot.devices.capabilities import CAPABILITIES, MOMENTARY
from homebot.devices.command_messages import Setting
from homebot.devices.part import check_setting
from homebot.devices.value import PlainValue
from homebot.devices.wording.values import value_text
from homebot.errors import RefusedError
from homebot.words.amounts import split_commands
from homebot.words.commands import SET, parse_command_words

_SAVED: Final = (*RESTORED, "fan_mode", "effect")
"""The capabilities of a saved scene, in the order of sending."""

_DEEDS: Final = MOMENTARY | {"scene", "locate"}
_BARE: Final = frozenset({"level", "color_temperature"})
"""Capabilities that are named by their unit."""

_HUES: Final = ("color", "color_temperature")
_OFF: Final = {"on_off": False, "thermostat_mode": "off"}


def values_text(settings: Iterable[Setting]) -> str:
    """Return *settings* in words."""
    return ", ".join(_words(setting.capability, setting.value.plain()) for setting in settings)


def _words(capability: str, value: PlainValue) -> str:
    if isinstance(value, bool):
        word = "on" if value else "off"
        return word if capability == "on_off" else f"{capability} {word}"
    text = value_text(capability, value)
    return text if capability in _BARE else f"{capability} {text}"


def read_values(words: str, device: Device, part: DevicePart, name: str) -> dict[str, PlainValue]:
    """Return the values by capability that *words* give to *part*.

    Raises:
        RefusedError: It does not take them, or nothing lasting; or one is a code, which is never kept.
    """
    values: dict[str, PlainValue] = {}
    for word in split_commands(words):
        given = parse_command_words(word, (), part.part, name)
        if any(values.get(capability, value) != value for capability, value in given.items()):
            raise RefusedError(f"{words} for {name}", "these contradict each other; give one of them")
        values |= given
    if deed := next((capability for capability in values if capability in _DEEDS), ""):
        raise RefusedError(f"{deed} of {name}", "a scene has values that last; use a routine for what is done once")
    if len(values) > 1:  # together they may contradict each other
        texts = [KeyValue(key=capability, value=_value_words(value)) for capability, value in values.items()]
        parse_command_words(SET, texts, part.part, name)
    settings = tuple(map(Setting.of, values, values.values()))
    if without_codes(settings, device, part) != settings:
        raise RefusedError(f"a code for {name}", "no scene keeps one")
    return values


def _value_words(value: PlainValue) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return " ".join(map(repr, value)) if isinstance(value, tuple) else str(value)


def present_values(device: Device, part: DevicePart) -> dict[str, PlainValue]:
    """Return the known values of *part* that a scene can bring back; empty if none is known."""
    states = {state.capability: state for state in device.states if state.part == part.id}
    known: list[str] = [capability for capability in _SAVED if capability in states]
    values = {capability: states[capability].value.plain() for capability in known}
    taken = {capability: value for capability, value in values.items() if _is_taken(part, capability, value)}
    # values that contradict others go
    for capability, off in _OFF.items():
        if taken.get(capability) == off:
            return {capability: off}
    if "position" in taken:
        taken.pop("movement", None)
    if all(capability in taken for capability in _HUES):  # it shows the one that it took on last
        taken.pop(min(_HUES, key=lambda capability: states[capability].since.to_seconds()))
    return taken


def _is_taken(part: DevicePart, capability: str, value: PlainValue) -> bool:
    if value is None or value in CAPABILITIES[capability].only_reported:
        return False
    try:
        check_setting(part.id, part.part, capability, value)
    except RefusedError:
        return False
    return True
