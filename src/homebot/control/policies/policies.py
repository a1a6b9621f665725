"""Policies of a home, in the order in which they check a command. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from datetime import time
from functools import partial
from typing import TYPE_CHECKING, Final, TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.control.policies.home_policy import home_policies
from homebot.control.policies.house import OCCUPANCY
from homebot.control.policies.interlock import InterlockRule, check_interlock
from homebot.control.policies.presence_guard import CONTACT, check_presence
from homebot.control.policies.rights import check_approval, check_grants
from homebot.control.policies.settings import PolicySettings, QuietHours, RateLimitSettings
from homebot.devices.query import CanDo, Or, Query

if TYPE_CHECKING:
    from homebot.control.policies.home_policy import NamedPolicy

__all__ = ["Policies", "Policy", "is_within"]

QUIET_HOURS: Final = "quiet_hours"
RATE_LIMIT: Final = "rate_limit"

Policy: TypeAlias = Callable[[IssuedCommand, Facts], Verdict]


@final
class Policies:
    """The policies of the settings.

    Args:
        settings: The policies and their tables.

    Attributes:
        needs: The query for the devices with values that some policy needs.
    """

    def __init__(self, settings: PolicySettings) -> None:
        installed = _installed(settings)
        self._policies = tuple(_policies(settings, installed))
        own = [one.policy.needs for one in installed if one.policy.needs is not None]
        self.needs: Query = Or((*_needs(settings), *own))

    def check(self, command: IssuedCommand, facts: Facts) -> tuple[Verdict, ...]:
        """Return the verdicts up to the first refusal, which is the last of them then."""
        verdicts: list[Verdict] = []
        for policy in self._policies:
            verdict = policy(command, facts)
            verdicts.append(verdict)
            if not verdict.allowed:
                break
        return tuple(verdicts)


def _installed(settings: PolicySettings) -> tuple[NamedPolicy, ...]:
    if not settings.policies:
        return ()

    return tuple(home_policies(settings.policies))


def _policies(settings: PolicySettings, installed: Iterable[NamedPolicy]) -> Iterator[Policy]:
    """Yield the policies: first rights, then dangers, then times."""
    yield partial(check_grants, settings.approvals)
    if settings.approvals:
        yield check_approval
    for interlock in settings.interlocks:
        yield partial(check_interlock, InterlockRule.of(interlock))
    for hours in settings.quiet_hours:
        yield partial(check_quiet_hours, hours)
    if settings.presence_guard is not None:
        yield partial(check_presence, settings.presence_guard)
    for one in installed:
        yield one.check
    if settings.rate_limit is not None:
        yield partial(check_rate, settings.rate_limit)


def _needs(settings: PolicySettings) -> Iterator[Query]:
    if settings.presence_guard is not None:
        yield CanDo(OCCUPANCY)
        if settings.presence_guard.doors:
            yield CanDo(CONTACT)
    for interlock in settings.interlocks:
        yield InterlockRule.of(interlock).possible


def check_quiet_hours(hours: QuietHours, command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command of an app at hours that *hours* exclude."""
    if not command.is_by_person and any(pattern.fits(command, facts) for pattern in hours.commands):
        now = facts.local_time.time()
        if is_within(now, hours.start, hours.end):
            used = FactUsed("local time", f"{now:%H:%M}", facts.now)
            reason = f"it is {now:%H:%M}, and quiet from {hours.start:%H:%M} to {hours.end:%H:%M}"
            return Verdict(QUIET_HOURS, allowed=False, reason=reason, facts=(used,))
    return Verdict(QUIET_HOURS, allowed=True)


def is_within(now: time, start: time, end: time) -> bool:
    """Return whether *now* is from *start* to before *end*, over midnight if *end* is the earlier one."""
    if start <= end:
        return start <= now < end
    return now >= start or now < end


def check_rate(settings: RateLimitSettings, command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command that turns a value once more than *settings* allow."""
    turns = facts.turns.count(command, facts.monotonic, settings.seconds)
    if turns < settings.changes:
        return Verdict(RATE_LIMIT, allowed=True)
    used = FactUsed(f"changes of {command.target} in {settings.seconds:g} s", float(turns))
    reason = f"{command.label} was switched to and fro {turns} times within {settings.seconds:g} s"
    return Verdict(RATE_LIMIT, allowed=False, reason=reason, facts=(used,))
