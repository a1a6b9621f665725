"""Verdicts of policies. Pure."""

from __future__ import annotations

from typing import NamedTuple

from homebot.devices.value import PlainValue

__all__ = ["FactUsed", "Verdict"]


class FactUsed(NamedTuple):
    """Fact behind a verdict.

    Attributes:
        name: For example ``occupancy of motion/hall``.
        value: Its value; None if that is unknown.
        since: The beginning of that value, in seconds since the Unix epoch; 0 if that is unknown.
    """

    name: str
    value: PlainValue
    since: float = 0.0


class Verdict(NamedTuple):
    """Answer of one policy to one command.

    Attributes:
        policy: The name of the policy.
        allowed: Whether the command may be sent.
        reason: The reason; empty if the policy does not concern the command.
        facts: The facts behind it.
    """

    policy: str
    allowed: bool
    reason: str = ""
    facts: tuple[FactUsed, ...] = ()
