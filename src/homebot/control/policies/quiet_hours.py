"""Quiet hours: what makes noise or light is not done by itself at night. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import time
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts
from homebot.control.policies.settings import QuietHours
from homebot.control.policies.verdict import FactUsed, Verdict

__all__ = ["is_within", "judge_quiet_hours"]

NAME: Final = "quiet_hours"

_NOT_CONCERNED: Final = Verdict(NAME, allowed=True)


def judge_quiet_hours(tables: Iterable[QuietHours], command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command of an app that one of *tables* keeps for other hours."""
    if command.is_wish:
        return _NOT_CONCERNED
    for hours in tables:
        if any(pattern.fits(command, facts) for pattern in hours.commands):
            now = facts.local_time.time()
            if is_within(now, hours.start, hours.end):
                used = FactUsed("local time", f"{now:%H:%M}", facts.now)
                reason = f"it is {now:%H:%M}, and quiet from {hours.start:%H:%M} to {hours.end:%H:%M}"
                return Verdict(NAME, allowed=False, reason=reason, facts=(used,))
    return _NOT_CONCERNED


def is_within(now: time, start: time, end: time) -> bool:
    """Return whether *now* is from *start* to before *end*, over midnight where *end* is the earlier one."""
    if start <= end:
        return start <= now < end
    return now >= start or now < end
