"""Policies: reasons to refuse a command of any issuer, as small pure functions of a command and facts."""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.control.policies.facts import Facts, FactUsed, Verdict
    from homebot.control.policies.home_policy import HomePolicy
    from homebot.control.policies.house import House, SensorReading

__all__ = [
    "FactUsed",
    "Facts",
    "HomePolicy",
    "House",
    "SensorReading",
    "Verdict",
]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.control.policies.facts": "FactUsed Facts Verdict",
            "homebot.control.policies.home_policy": "HomePolicy",
            "homebot.control.policies.house": "House SensorReading",
        },
    )
