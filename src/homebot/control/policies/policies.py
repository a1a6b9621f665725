"""The policies of a home, in the order in which they are asked. Pure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts
from homebot.control.policies.presence_guard import OCCUPANCY, judge_presence
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
        self._policies: list[Policy] = []
        needs: list[Query] = []
        if settings.presence_guard is not None:
            self._policies.append(partial(judge_presence, settings.presence_guard))
            needs.append(CanDo(OCCUPANCY))
        self.needs: Query = Or(tuple(needs))

    def judge(self, command: IssuedCommand, facts: Facts) -> tuple[Verdict, ...]:
        """Return the verdicts on *command*, up to the first refusal, which is the last of them then."""
        verdicts: list[Verdict] = []
        for policy in self._policies:
            verdict = policy(command, facts)
            verdicts.append(verdict)
            if not verdict.allowed:
                break
        return tuple(verdicts)
