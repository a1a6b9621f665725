"""A command between its first sending and its outcome."""

import asyncio
import math
from collections.abc import Awaitable
from dataclasses import dataclass, field
from typing import ClassVar, Final, Protocol, TypeVar

from homebot.control import durations
from homebot.control.command import IssuedCommand
from homebot.control.timeline.facts import Reported, ReportRole
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.outcomes import Outcome
from homebot.support.time_limits import TimeLimits

_T = TypeVar("_T")

_MAX_RECORDED: Final = 20
"""The limit of reports of one command in the journal."""

_ON_THE_WAY: Final = (ReportRole.STEP, ReportRole.DEVIATES)


class SimulatedExecution(Protocol):
    """Answers commands instead of sending them.

    Attributes:
        is_live: Whether the devices are real, so a raw command has no effect; in a replay it has its recorded effect.
    """

    is_live: ClassVar[bool]

    def outcome(self, command: IssuedCommand) -> Outcome | None:
        """Return the assumed outcome of *command*; None to send it to a muted gateway."""
        ...


@dataclass(slots=True, eq=False)
class OpenCommand:
    """A command without an outcome.

    Its only task waits with a future and a shared timer: an event with a timeout would cost several times as much.

    Attributes:
        recorded: The last report of each capability in the journal, which does not record it twice.
        members: The timelines of the members of a group.
    """

    command: IssuedCommand
    timeline: PartTimeline
    progress: CommandProgress
    limits: TimeLimits
    recorded: dict[str, object] = field(default_factory=dict)
    members: tuple[PartTimeline, ...] = ()
    _acknowledging: asyncio.Timeout | None = None
    _waiter: asyncio.Future[None] | None = None

    def is_news(self, fact: Reported) -> bool:
        """Return whether a report differs from the last recorded one, and remember it; all steps on the way are one."""
        role = fact.attribution.role if fact.attribution.command == self.command.id else None
        news = (ReportRole.STEP, None) if role in _ON_THE_WAY else (role is ReportRole.ECHO, fact.value)
        if self.recorded.get(fact.capability) == news or len(self.recorded) >= _MAX_RECORDED:
            return False
        self.recorded[fact.capability] = news
        return True

    def wake(self) -> None:
        """Wake the task if it is waiting; a task that checks before it waits misses nothing."""
        limit, progress = self._acknowledging, self.progress
        if limit is not None and limit.when() is None and progress.wanted and progress.over_at == -math.inf:
            limit.reschedule(asyncio.get_running_loop().time() + durations.ACKNOWLEDGED_TOO)
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)

    async def wait(self, seconds: float) -> None:
        """Wait up to *seconds* for news."""
        self._waiter = asyncio.get_running_loop().create_future()
        limit = self.limits.set(seconds, self.wake)
        try:
            await self._waiter
        finally:
            self.limits.discard(limit)

    async def acknowledged(self, sending: Awaitable[_T]) -> _T | None:
        """Return the result of *sending*; None if it has none a second after the part reported what was wanted."""
        limit = self._acknowledging = asyncio.timeout(None)
        try:
            async with limit:
                return await sending
        except TimeoutError:
            if not limit.expired():
                raise
            return None
        finally:
            self._acknowledging = None
