"""Rate limit: no value is switched to and fro without end. Pure."""

from __future__ import annotations

from typing import Final

from pydantic import Field

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.units import Seconds

__all__ = ["RateLimitSettings"]

NAME: Final = "rate_limit"

_WITHIN: Final = Verdict(NAME, allowed=True)


class RateLimitSettings(PolicyTable):
    """The table ``[control.rate_limit]``.

    Attributes:
        changes: The number of turns of a value that are allowed within *seconds*.
    """

    changes: int = Field(default=30, ge=1, le=1000)
    seconds: Seconds = 10.0

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse a command that turns a value once more than is allowed."""
        turns = facts.turns.count(command, facts.monotonic, self.seconds)
        if turns < self.changes:
            return _WITHIN
        used = FactUsed(f"changes of {command.target} in {self.seconds:g} s", float(turns))
        reason = f"{command.label} was switched to and fro {turns} times within {self.seconds:g} s"
        return Verdict(NAME, allowed=False, reason=reason, facts=(used,))
