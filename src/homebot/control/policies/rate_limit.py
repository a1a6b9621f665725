"""Rate limit: no device is switched to and fro like a strobe. Pure."""

from __future__ import annotations

from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.control.policies.settings import RateLimitSettings

__all__ = ["check_rate"]

NAME: Final = "rate_limit"


def check_rate(settings: RateLimitSettings, command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command that turns a value once more than *settings* allow."""
    turns = facts.turns.count(command, facts.monotonic, settings.seconds)
    if turns < settings.changes:
        return Verdict(NAME, allowed=True)
    used = FactUsed(f"changes of {command.target} in {settings.seconds:g} s", float(turns))
    reason = f"{command.label} was switched to and fro {turns} times within {settings.seconds:g} s"
    return Verdict(NAME, allowed=False, reason=reason, facts=(used,))
