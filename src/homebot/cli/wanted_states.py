"""The state that the user misses at a device, compared with its present and possible states. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from homebot.cli.command_records import SettingRecord
from homebot.cli.device_history import COMMANDED_STATES, as_state, means, settable_states
from homebot.cli.records import CapabilityRecord, DeviceRecord, StateRecord
from homebot.cli.table import printable
from homebot.cli.values import plain_value, span
from homebot.devices.capabilities import CAPABILITIES

__all__ = ["command_for", "is_so", "unknown_state"]

_WORDS: Final[Mapping[str, str]] = MappingProxyType({state: word for word, state in COMMANDED_STATES.items()})
_FLAGS: Final = ("on", "off", "true", "false", "yes", "no")
_MOST: Final = 6


def is_so(device: DeviceRecord, wanted: str) -> bool:
    """Return whether the last report of a commandable state is *wanted*."""
    states = list(settable_states(device))
    off = {one["part"] for one in states if one["capability"] == "on_off" and plain_value(one["value"]) is False}
    return any(
        means(_setting(one), as_state(wanted))
        for one in states
        if one["capability"] == "on_off" or one["part"] not in off  # a lamp that is off is not at its level
    )


def unknown_state(device: DeviceRecord, wanted: str) -> str:
    """Return in a sentence why no command can have *device* be *wanted*; empty if one may."""
    settable = [one for one in _capabilities(device) if one["settable"]]
    if not device["parts"]:
        return ""
    if not settable:
        return "It takes no commands, it only reports."
    if any(_may_be(one, as_state(wanted)) for one in _capabilities(device)):
        return ""
    known = "; ".join(_choice(one) for one in settable[:_MOST])
    return f"It has no state {printable(wanted, 40)!r}. It takes {known}{'; …' if len(settable) > _MOST else ''}."


def command_for(device: DeviceRecord, wanted: str) -> str:
    """Return the word with which `homebot do` asks *device* for *wanted*; empty if it takes more than a word."""
    folded = as_state(wanted)
    if folded in _WORDS:
        return _WORDS[folded]
    options = {option.casefold() for one in _capabilities(device) if one["settable"] for option in one["options"]}
    return folded if folded in {"on", "off", "open", *options} and " " not in folded else ""


def _capabilities(device: DeviceRecord) -> Iterable[CapabilityRecord]:
    return (one for part in device["parts"] for one in part["part"]["capabilities"])


def _setting(state: StateRecord) -> SettingRecord:
    return {"capability": state["capability"], "value": state["value"]}


def _may_be(capability: CapabilityRecord, wanted: str) -> bool:
    known = CAPABILITIES.get(capability["name"])
    options = {option.casefold() for option in _options(capability)}
    if known is None or (known.kind == "text" and not options):
        return True
    if known.kind == "bool":
        return wanted in _FLAGS
    if options:
        return wanted in options or any(COMMANDED_STATES.get(one) == wanted for one in options)
    return any(char.isdigit() for char in wanted) or wanted in {"on", "off", "open", "closed"}


def _options(capability: CapabilityRecord) -> Sequence[str]:
    """Return the texts that it may be: its own, else those of the vocabulary."""
    known = CAPABILITIES.get(capability["name"])
    return capability["options"] or (known.options if known is not None else ())


def _choice(capability: CapabilityRecord) -> str:
    known = CAPABILITIES.get(capability["name"])
    is_flag = known is not None and known.kind == "bool"
    values = "on or off" if is_flag else span(capability) or ", ".join(_options(capability))
    return printable(f"{capability['name']} {values}".rstrip(), 120)
