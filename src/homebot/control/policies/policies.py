"""Policies of a home, in the order in which they check a command. Pure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, Verdict
from homebot.control.policies.rights import check_approval, check_grants
from homebot.control.policies.settings import PolicySettings
from homebot.devices.query import Or, Query

__all__ = ["Policies", "Policy"]

Policy: TypeAlias = Callable[[IssuedCommand, Facts], Verdict]


@final
class Policies:
    """The policies of the settings: first rights, then dangers, then times.

    Attributes:
        needs: The query for the devices with values that some policy needs.
    """

    def __init__(self, settings: PolicySettings) -> None:
        tables = tuple(settings.tables())
        rights: tuple[Policy, ...] = (partial(check_grants, settings.approvals),)
        rights += (check_approval,) if settings.approvals else ()
        self._policies = (*rights, *(one.judge for one in tables))
        self.needs: Query = Or(tuple(one.needs for one in tables if one.needs is not None))

    def check(self, command: IssuedCommand, facts: Facts) -> tuple[Verdict, ...]:
        """Return the verdicts up to the first refusal, which is the last of them then."""
        verdicts: list[Verdict] = []
        for policy in self._policies:
            verdict = policy(command, facts)
            verdicts.append(verdict)
            if not verdict.allowed:
                break
        return tuple(verdicts)
