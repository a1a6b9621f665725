"""Facts against which policies check a command, and their verdicts. Pure."""

import math
from abc import abstractmethod
from collections.abc import Callable
from datetime import datetime, tzinfo
from typing import NamedTuple

from pydantic import BaseModel, ConfigDict

from homebot.control.command import IssuedCommand
from homebot.control.policies.house import House
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices import Device, DevicePart
from homebot.devices.query.terms import Query
from homebot.devices.value import PlainValue


class Facts(NamedTuple):
    """A read-only view of the house at one moment.

    Attributes:
        now: Seconds since the Unix epoch.
        monotonic: Seconds of the monotonic clock.
        zone: The time zone of the home; None for the computer's.
        robot_in: Returns a robot that is on its way in a room, or to it; empty for none.
        clock_set_at: When the computer's clock was last set, or its sleep ended, by the monotonic clock.
    """

    now: float
    monotonic: float
    zone: tzinfo | None
    house: House
    timeline_of: Callable[[Device, DevicePart], PartTimeline]
    robot_in: Callable[[str], str] = lambda _: ""
    clock_set_at: float = -math.inf

    def age(self, stamp: float) -> float:
        """Return the seconds since *stamp*, at most those since the clock was set."""
        since_set = self.monotonic - self.clock_set_at
        if stamp > self.now:
            return since_set if since_set < math.inf else 0.0
        return min(self.now - stamp, since_set)

    def certain(self, command: IssuedCommand, capability: str) -> PlainValue:
        """Return the value of *capability* of the commanded part; None unless it is certain, whatever *command* did."""
        state = command.states.get(capability)
        if state is None:
            return None
        timeline, told_at = self.timeline_of(command.device, command.part), state.told_at.to_seconds()
        value, now = command.values[capability], self.monotonic
        return timeline.certain(capability, value, now - self.age(told_at), now, command.id)

    @property
    def local_time(self) -> datetime:
        """The time in the home."""
        return datetime.fromtimestamp(self.now, self.zone)


class FactUsed(NamedTuple):
    """Fact behind a verdict.

    Attributes:
        name: For example ``occupancy of motion/hall``.
        value: Its value; None if unknown.
        since: When it took that value, in seconds since the Unix epoch; 0 if unknown.
    """

    name: str
    value: PlainValue
    since: float = 0.0


class Verdict(NamedTuple):
    """Answer of one policy to one command.

    Attributes:
        reason: The reason; empty if the policy does not concern the command.
        warns: Whether a person is warned by the reason of an allowed command.
    """

    policy: str
    allowed: bool
    reason: str = ""
    facts: tuple[FactUsed, ...] = ()
    warns: bool = False


class PolicyTable(BaseModel):
    """A policy of homebot: its table in the configuration, and its check of a command."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @property
    def needs(self) -> Query | None:
        """The query for the devices that the policy reads from ``facts.house``; None for none."""
        return None

    @abstractmethod
    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Return the verdict."""
