"""The policies of a home, in the order in which they are asked. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.policies.approval import concerns_approval, judge_approval
from homebot.control.policies.closed_room import CONTACT
from homebot.control.policies.command_pattern import Patterns
from homebot.control.policies.facts import Facts
from homebot.control.policies.grants import NAME as GRANTS
from homebot.control.policies.grants import concerns_grants, judge_grants
from homebot.control.policies.house import OCCUPANCY
from homebot.control.policies.interlock import InterlockRule, judge_interlocks
from homebot.control.policies.presence_guard import judge_presence
from homebot.control.policies.quiet_hours import judge_quiet_hours
from homebot.control.policies.rate_limit import judge_rate
from homebot.control.policies.settings import PolicySettings
from homebot.control.policies.verdict import Verdict
from homebot.devices.query import CanDo, Or, Query

if TYPE_CHECKING:
    from homebot.control.policies.home_policy import NamedPolicy

__all__ = ["Policies", "Policy"]

Policy: TypeAlias = Callable[[IssuedCommand, Facts], Verdict]


_MOST_PARTS: Final = 10_000
"""Parts of which it is remembered which policies concern them; the one asked about first is forgotten first."""

_NOT_CONCERNED: Final = (Verdict(GRANTS, allowed=True),)


@final
class Policies:
    """The policies that are on.

    Which of them may concern a part, whatever is commanded and reported, is worked out once, until the directory
    describes its device anew: most parts are nobody's concern but the rate limit's.

    Args:
        settings: Which, and how.

    Attributes:
        needs: The query for the devices whose values some policy needs.
    """

    def __init__(self, settings: PolicySettings) -> None:
        others = _of_packages(settings)
        self._rules = tuple(_rules(settings, others))
        self._concerned: dict[_Place, tuple[_Described, tuple[Policy, ...]]] = {}
        self.needs: Query = Or(
            (*_needs(settings), *[one.policy.needs for one in others if one.policy.needs is not None])
        )

    def judge(self, command: IssuedCommand, facts: Facts) -> tuple[Verdict, ...]:
        """Return the verdicts of those that may concern *command*, up to the first refusal, the last of them then."""
        verdicts: list[Verdict] = []
        for policy in self._concerning(command):
            verdict = policy(command, facts)
            verdicts.append(verdict)
            if not verdict.allowed:
                break
        return tuple(verdicts) or _NOT_CONCERNED

    def _concerning(self, command: IssuedCommand) -> tuple[Policy, ...]:
        device, place = command.device, (*command.place, command.issuer)
        described: _Described = (
            command.part,
            device.parts,
            command.rights,
            device.name,
            device.names,
            device.area,
            device.outer_areas,
            device.tags,
            device.facts,
            device.metadata,
            device.conflicts,
        )
        known = self._concerned.get(place)
        if known is not None and known[0] == described:
            return known[1]
        found = tuple(one.judge for one in self._rules if one.concerns(command))
        self._concerned[place] = described, found
        if len(self._concerned) > _MOST_PARTS:
            del self._concerned[next(iter(self._concerned))]
        return found


_Place: TypeAlias = tuple[str, str, str]

_Described: TypeAlias = tuple[object, ...]
"""What it depends on whether a policy may concern a part; mostly the very same objects as the time before."""


class _PolicyRule(NamedTuple):
    """A policy, and which commands it may concern by issuer and part alone."""

    concerns: Callable[[IssuedCommand], bool]
    judge: Policy


def _of_packages(settings: PolicySettings) -> tuple[NamedPolicy, ...]:
    if not settings.policies:
        return ()
    from homebot.control.policies.home_policy import home_policies  # noqa: PLC0415 - few homes have any

    return tuple(home_policies(settings.policies))


def _rules(settings: PolicySettings, others: Iterable[NamedPolicy]) -> Iterator[_PolicyRule]:
    """Yield the policies that are on: who may, before what may be done, before when."""
    yield _PolicyRule(concerns_grants, partial(judge_grants, settings.approvals))
    if settings.approvals:
        yield _PolicyRule(concerns_approval, judge_approval)
    for interlock in map(InterlockRule.of, settings.interlocks):
        yield _PolicyRule(partial(_is_among, interlock.interlock.commands), partial(judge_interlocks, (interlock,)))
    for hours in settings.quiet_hours:
        yield _PolicyRule(partial(_is_by_itself_among, hours.commands), partial(judge_quiet_hours, (hours,)))
    if (guard := settings.presence_guard) is not None:
        yield _PolicyRule(partial(_is_by_itself_among, guard.commands), partial(judge_presence, guard))
    for one in others:
        yield _PolicyRule(_any_command, one.judge)
    if settings.rate_limit is not None:
        yield _PolicyRule(_any_command, partial(judge_rate, settings.rate_limit))


def _is_among(patterns: Patterns, command: IssuedCommand) -> bool:
    return any(one.may_concern(command.device, command.part) for one in patterns)


def _is_by_itself_among(patterns: Patterns, command: IssuedCommand) -> bool:
    return not command.is_client and _is_among(patterns, command)


def _any_command(_: IssuedCommand) -> bool:
    return True


def _needs(settings: PolicySettings) -> Iterator[Query]:
    if settings.presence_guard is not None:
        yield CanDo(OCCUPANCY)
        if settings.presence_guard.doors:
            yield CanDo(CONTACT)
    for interlock in settings.interlocks:
        yield InterlockRule.of(interlock).possible
