"""Quiet hours: apps make no noise and no light at night. Pure."""

from __future__ import annotations

from datetime import time
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.control.policies.settings import QuietHours

__all__ = ["check_quiet_hours", "is_within"]

NAME: Final = "quiet_hours"


def check_quiet_hours(hours: QuietHours, command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command of an app at hours that *hours* exclude."""
    if not command.is_by_person and any(pattern.fits(command, facts) for pattern in hours.commands):
        now = facts.local_time.time()
        if is_within(now, hours.start, hours.end):
            used = FactUsed("local time", f"{now:%H:%M}", facts.now)
            reason = f"it is {now:%H:%M}, and quiet from {hours.start:%H:%M} to {hours.end:%H:%M}"
            return Verdict(NAME, allowed=False, reason=reason, facts=(used,))
    return Verdict(NAME, allowed=True)


def is_within(now: time, start: time, end: time) -> bool:
    """Return whether *now* is from *start* to before *end*, over midnight if *end* is the earlier one."""
    if start <= end:
        return start <= now < end
    return now >= start or now < end
