"""Values of a part that are certain before a command. Pure."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import NamedTuple

from homebot.control import durations
from homebot.control.command import IssuedCommand
from homebot.devices.value import PlainValue

__all__ = ["KnownState", "known_state"]


class KnownState(NamedTuple):
    """Certain values of a part.

    Attributes:
        values: The values by capability.
        is_recent: Whether all that are asked for were reported live within a minute, and since the connection was lost.
    """

    values: dict[str, PlainValue]
    is_recent: bool


_NOTHING = KnownState({}, is_recent=False)


def known_state(
    command: IssuedCommand, asked: Collection[str], unsure_since: Mapping[str, float], lost_at: float = -math.inf
) -> KnownState:
    """Return the certain values of the commanded part.

    A retained value is certain of a device that is online, by its last will: many report only changes. After a failed
    command older values are not certain, and newer ones are not recent.

    Args:
        command: The command.
        asked: The capabilities that count.
        unsure_since: When a command for each capability failed, in seconds since the Unix epoch.
        lost_at: When the connection was last lost, in seconds since the Unix epoch.
    """
    is_online = command.device.reachable.state == "yes"
    if not (is_online or command.device.freshness == "fresh"):
        return _NOTHING
    values: dict[str, PlainValue] = {}
    is_recent = True
    for state in command.device.states:
        capability = state.capability
        if capability not in asked or state.part != command.part.id or not (state.live or is_online):
            continue
        told_at, unsure_at = state.told_at.to_seconds(), unsure_since.get(capability)
        is_sure = state.live and unsure_at is None and told_at > lost_at
        is_recent = is_recent and is_sure and abs(command.issued_at - told_at) <= durations.FRESH
        if unsure_at is None or told_at > unsure_at:
            values[capability] = state.value.plain()
    return KnownState(values, is_recent)
