"""Verdicts of policies, as data. Pure."""

from __future__ import annotations

from typing import NamedTuple

from homebot.devices.value import PlainValue

__all__ = ["FactUsed", "Verdict"]


class FactUsed(NamedTuple):
    """One fact that a verdict rests on.

    Attributes:
        name: The name, for example ``occupancy of motion/hall``.
        value: The value; None where it is unknown.
        since: Since when it has been so, in seconds since the Unix epoch; 0 where that is unknown.
    """

    name: str
    value: PlainValue
    since: float = 0.0


class Verdict(NamedTuple):
    """The answer of one policy to one command.

    Attributes:
        policy: The name of the policy, for example ``presence_guard``.
        allowed: Whether the command may be sent.
        reason: The reason, as text; empty where the policy does not concern the command.
        facts: The facts that it rests on.
    """

    policy: str
    allowed: bool
    reason: str = ""
    facts: tuple[FactUsed, ...] = ()
