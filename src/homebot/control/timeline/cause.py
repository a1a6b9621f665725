"""Cause of a report: a command to the part or to one near it, a device by itself, a person, or unknown. Pure."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple, TypeAlias

from homebot.control import durations
from homebot.control.timeline.facts import Order, PartRef, Reported, ReportRole
from homebot.control.timeline.goal import side_role
from homebot.control.timeline.profile import ENOUGH, DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.device import target_of
from homebot.devices.obedience import STOPPED, departs, fits
from homebot.devices.value import PlainValue

__all__ = [
    "MOST_NEARBY",
    "NOWHERE",
    "Attribution",
    "Cause",
    "HeldValue",
    "Nearby",
    "NearbyCommands",
    "cause_of",
    "cause_of_undoing",
]


class Cause(Enum):
    """Cause of a report.

    ``COMMAND``: the effect of a command. ``TRANSITION``: a step on the way. ``ECHO``: a bridge repeated a command.
    ``DEVICE``: the device by itself. ``PERSON``: a person, or a program past homebot. ``UNKNOWN``: a person or the
    device.
    """

    COMMAND = "command"
    TRANSITION = "transition"
    ECHO = "echo"
    DEVICE = "device"
    PERSON = "person"
    UNKNOWN = "unknown"

    @property
    def may_be_person(self) -> bool:
        """True if it has to be treated as a person's action, to be safe."""
        return self in {Cause.PERSON, Cause.UNKNOWN}


class Attribution(NamedTuple):
    """Cause of a report.

    Attributes:
        command: The id of the command that caused the report, or whose effect it ended; empty for none.
        role: The role of the report for that command; None without one, and for a command to another part.
    """

    cause: Cause
    command: str = ""
    role: ReportRole | None = None


_OF_ROLE: Final = {ReportRole.EFFECT: Cause.COMMAND, ReportRole.ECHO: Cause.ECHO, ReportRole.STEP: Cause.TRANSITION}
_RESTS: Final = frozenset({"open", "closed", STOPPED})
"""States of a motor at rest."""

_NO_COMMAND: Final = Attribution(Cause.PERSON)
_NOT_KNOWN: Final = Attribution(Cause.UNKNOWN)
_TIMED: Final = Attribution(Cause.DEVICE)


def cause_of(fact: Reported, commands: Iterable[CommandProgress]) -> Attribution:
    """Return the cause of a report.

    Args:
        commands: The commands to the part, newest first.
    """
    answered = _NO_COMMAND
    for command in commands:
        role = command.roles.get(fact.number)
        cause = None if role is None else _cause(role, fact, command)
        if cause is not None:
            cause = Cause.PERSON if command.order.is_foreign else cause
            return Attribution(cause, command.order.id, None if command.is_raw else role)
        if role is ReportRole.OTHERWISE and fact.at <= command.ended_at:
            answered = Attribution(Cause.PERSON, command.order.id, role)
    return _cause_without_command(fact) or answered


@dataclass(slots=True, eq=False)
class HeldValue:
    """Value that a lease holds: a fold of the reports and commands of its part as long as the lease lasts.

    Attributes:
        on_report: Called with each report of the value and None, with the first report of another one and its cause.
        is_so: Whether the part is known to have it.
    """

    capability: str
    value: PlainValue
    profile: DeviceProfile
    on_report: Callable[[PlainValue, Attribution | None], None]
    is_so: bool = False

    def confirm(self, settings: Mapping[str, PlainValue]) -> None:
        """Record that a command with *settings* has succeeded."""
        self.is_so = self.is_so or settings.get(self.capability) == self.value

    def report(self, capability: str, value: PlainValue, found: Attribution) -> None:
        """Record a report and its cause; an intermediate step says nothing."""
        if capability != self.capability or found.cause is Cause.TRANSITION:
            return
        if self.profile.fits(capability, self.value, value):
            self.is_so = self.is_so or found.cause is not Cause.ECHO
            self.on_report(value, None)
        elif self.is_so and self.profile.departs(capability, self.value, value):
            self.is_so = False
            self.on_report(value, found)


def _cause_without_command(fact: Reported) -> Attribution | None:
    """Return the cause of a report that no command to its part explains; None if it may be a person."""
    if fact.value is None or fact.is_first or fact.is_after_loss:
        return _NOT_KNOWN
    if fact.along:
        return Attribution(Cause.COMMAND, fact.along) if fact.is_usual else _NOT_KNOWN
    if fact.timed >= ENOUGH:
        return _TIMED
    return _NOT_KNOWN if fact.timed and fact.at - fact.since > durations.HASTY else None


def cause_of_undoing(command: CommandProgress, capability: str) -> Cause:
    """Return the cause of the end of a wanted value: the device if it is known to go back, else unknown."""
    undoing = command.settling.undoing if command.settling is not None else None
    usual = command.usual_returns.get(capability)
    if undoing is not None and usual is not None and abs(undoing.after - usual) <= durations.REGULAR:
        return Cause.DEVICE
    return Cause.DEVICE if capability in command.suspected else Cause.UNKNOWN


def _cause(role: ReportRole, fact: Reported, command: CommandProgress) -> Cause | None:
    """Return the cause of a report with *role* for *command*; None if the command does not explain it."""
    if role in _OF_ROLE:
        return _OF_ROLE[role]
    if fact.is_after_loss:
        return None
    if role is ReportRole.UNDONE:
        return cause_of_undoing(command, fact.capability)
    if role is ReportRole.ASTRAY:
        return Cause.UNKNOWN
    limit = durations.UNREAD if command.is_raw and not command.wanted else durations.CAME_ALONG
    if role is ReportRole.AGREES and (command.is_open or fact.at - _last_sign(command) <= limit):
        return Cause.COMMAND
    if role is ReportRole.ASIDE and _rests_where_sent(fact, command):
        return Cause.COMMAND
    return None


def _rests_where_sent(fact: Reported, command: CommandProgress) -> bool:
    """Return whether a cover arrived: halfway it reports open, stopped, or closed until it reports its position."""
    return fact.value in _RESTS and any(abs(fact.at - met) <= durations.CAME_ALONG for met in command.met_times)


def _last_sign(command: CommandProgress) -> float:
    """Return the time of the last sign that the command was in progress."""
    sendings, moved_at = command.transmission, command.motion.moved_at
    return max(sendings.sent_at, moved_at or command.given_at, *command.met_times, *sendings.accepted.values())


MOST_NEARBY: Final = 32
"""The limit of commands to one device, and to one room; older ones are dropped."""

NearbyCommands: TypeAlias = deque[CommandProgress]
"""The newest commands to one device, or to one room, oldest first."""


class Nearby(NamedTuple):
    """The commands to the device of a part, and to its room, each shared by all parts there."""

    device: NearbyCommands
    room: NearbyCommands

    def explain(self, fact: Reported, place: PartRef, profile: DeviceProfile) -> None:
        """Record in *fact*, a change of *place*, the command to another part that it came along with, and learn it."""
        for known in self:
            for command in reversed(known):
                is_open = known is self.device and command.is_open
                if command.order.place != place and _is_along(fact.at, command, is_open=is_open):
                    fact.along = command.order.id
                    fact.is_usual = _is_usual(fact, place, command, known, profile)
                    return


NOWHERE: Final = Nearby(deque(maxlen=0), deque(maxlen=0))


def _is_along(at: float, command: CommandProgress, *, is_open: bool) -> bool:
    """Return whether a change came with a sign of *command*, or, of a device that answers slowly, while it is open."""
    sendings = command.transmission
    if not sendings.count or at < sendings.first_sent_at:
        return False
    signs = (sendings.first_sent_at, sendings.sent_at, *command.met_times)
    return is_open or any(abs(at - one) <= durations.CAME_ALONG for one in signs)


def _is_usual(
    fact: Reported, place: PartRef, command: CommandProgress, known: NearbyCommands, profile: DeviceProfile
) -> bool:
    """Return whether the part usually changes along with commands to that other part; learn that it did."""
    order = command.order
    if not _agrees(order, fact):
        return False
    earlier = [one for one in known if one.order.place == order.place and fact.since < one.given_at < command.given_at]
    is_missed = any(_is_missed(one, fact, place) for one in earlier)
    command.followers |= {place}
    return profile.learn_pair(target_of(*order.place), is_missed=is_missed)


def _agrees(order: Order, fact: Reported) -> bool:
    wanted = order.settings.get(fact.capability)
    if wanted is None:
        return side_role(order, fact.capability, fact.value) is ReportRole.AGREES
    return fits(fact.capability, wanted, fact.value)


def _is_missed(command: CommandProgress, fact: Reported, place: PartRef) -> bool:
    """Return whether the part did not follow an earlier *command* to the same part, since it had the value before."""
    wanted = command.order.settings.get(fact.capability)
    return place not in command.followers and wanted is not None and departs(fact.capability, wanted, fact.previous)
