"""Policies: reasons to refuse a command of any issuer, as small pure functions of a command and facts."""

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.control.policies.home_policy import HomePolicy
from homebot.control.policies.house import House, SensorReading
from homebot.words.patterns import Patterns

__all__ = ["FactUsed", "Facts", "HomePolicy", "House", "IssuedCommand", "Patterns", "SensorReading", "Verdict"]
