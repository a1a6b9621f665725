"""The policies of a home, in the order in which they are asked. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.policies.approval import judge_approval
from homebot.control.policies.facts import Facts
from homebot.control.policies.grants import judge_grants
from homebot.control.policies.interlock import InterlockRule, judge_interlocks
from homebot.control.policies.presence_guard import OCCUPANCY, judge_presence
from homebot.control.policies.quiet_hours import judge_quiet_hours
from homebot.control.policies.rate_limit import judge_rate
from homebot.control.policies.settings import PolicySettings
from homebot.control.policies.verdict import Verdict
from homebot.devices.query import CanDo, Or, Query

__all__ = ["Policies", "Policy"]

Policy: TypeAlias = Callable[[IssuedCommand, Facts], Verdict]


@final
class Policies:
    """The policies that are on.

    Args:
        settings: Which, and how.

    Attributes:
        needs: The query for the devices whose values some policy needs.
    """

    def __init__(self, settings: PolicySettings) -> None:
        self._policies = tuple(_policies(settings))
        self.needs: Query = Or(tuple(_needs(settings)))

    def judge(self, command: IssuedCommand, facts: Facts) -> tuple[Verdict, ...]:
        """Return the verdicts on *command*, up to the first refusal, which is the last of them then."""
        verdicts: list[Verdict] = []
        for policy in self._policies:
            verdict = policy(command, facts)
            verdicts.append(verdict)
            if not verdict.allowed:
                break
        return tuple(verdicts)


def _policies(settings: PolicySettings) -> Iterator[Policy]:
    """Yield the policies that are on: who may, before what may be done, before when."""
    yield judge_grants
    if settings.approvals:
        yield judge_approval
    if settings.interlocks:
        yield partial(judge_interlocks, tuple(map(InterlockRule.of, settings.interlocks)))
    if settings.quiet_hours:
        yield partial(judge_quiet_hours, settings.quiet_hours)
    if settings.presence_guard is not None:
        yield partial(judge_presence, settings.presence_guard)
    if settings.rate_limit is not None:
        yield partial(judge_rate, settings.rate_limit)


def _needs(settings: PolicySettings) -> Iterator[Query]:
    if settings.presence_guard is not None:
        yield CanDo(OCCUPANCY)
    for interlock in settings.interlocks:
        yield InterlockRule.of(interlock).possible
