"""Quiet hours: times at which apps may not give some commands. Pure."""

from datetime import time
from typing import Annotated, Final, TypeAlias

from pydantic import AfterValidator, ValidationInfo, field_validator

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.words.patterns import Patterns
from homebot.words.times import TimeSpan

NAME: Final = "quiet_hours"


def _local(value: time) -> time:
    if value.tzinfo is not None:
        raise ValueError("must be a local time such as 22:00; `[home] zone` says where")
    return value


LocalTime: TypeAlias = Annotated[time, AfterValidator(_local)]


class QuietHours(PolicyTable):
    """A table ``[[control.quiet_hours]]``.

    Attributes:
        start: The local time at which they begin.
        end: The local time at which they end; on the next day if it is before *start*.
        commands: The commands that apps may not give during them.
    """

    start: LocalTime
    end: LocalTime
    commands: Patterns

    @field_validator("end")
    @classmethod
    def _is_another_time(cls, end: time, info: ValidationInfo) -> time:
        if end == info.data.get("start"):
            raise ValueError(f"is {end:%H:%M}, the same as start, so it would always be quiet")
        return end

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse a command of an app during these hours."""
        if not command.is_by_person and any(pattern.fits(command, facts) for pattern in self.commands):
            now = facts.local_time.time()
            if TimeSpan(self.start, self.end).has(now):
                used = FactUsed("local time", f"{now:%H:%M}", facts.now)
                reason = f"it is {now:%H:%M}, and quiet from {self.start:%H:%M} to {self.end:%H:%M}"
                return Verdict(NAME, allowed=False, reason=reason, facts=(used,))
        return Verdict(NAME, allowed=True)
