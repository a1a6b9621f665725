"""The value that a part is known to have: a newer command makes what it reported before uncertain. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts
from homebot.control.tolerance import fits
from homebot.devices.value import PlainValue

__all__ = ["known_value"]

_ON_ITS_WAY: Final = 300.0
"""Seconds after a command for which a report of another value may be one from the way there."""

_ROUNDING: Final = 0.001
"""Seconds by which stamps and the monotonic clock may differ: some devices answer at once."""

_MOVED_BY: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType({"position": ("position", "movement")})
_ENDS: Final[Mapping[PlainValue, float]] = MappingProxyType({"open": 100.0, "closed": 0.0})


def known_value(command: IssuedCommand, capability: str, facts: Facts) -> PlainValue:
    """Return what the commanded part last reported of *capability*; None where it need not be so any more.

    It need not once another command was sent after the report. Then a newer report counts if it says what that command
    wanted, and five minutes after the command in any case.
    """
    state = next(
        (one for one in command.device.states if one.capability == capability and one.part == command.part.id), None
    )
    if state is None:
        return None
    value, age = state.value.plain(), facts.age(state.told_at.to_seconds())
    for name in _MOVED_BY.get(capability, (capability,)):
        sent = facts.recent.last(command, name)
        if sent is None:
            continue
        wanted, sent_ago = sent[0], facts.monotonic - sent[1]
        is_there = fits(capability, _ENDS.get(wanted, wanted), value)
        if age > sent_ago + _ROUNDING or (not is_there and sent_ago < _ON_ITS_WAY):
            return None
    return value
