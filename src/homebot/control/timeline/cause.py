"""Cause of a report: a command, a device by itself, a person, or unknown. Pure."""

from collections.abc import Iterable
from enum import Enum
from typing import Final, NamedTuple

from homebot.control import durations
from homebot.control.timeline.facts import Reported, ReportRole
from homebot.control.timeline.profile import ENOUGH
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.obedience import STOPPED

__all__ = ["Attribution", "Cause", "cause_of", "cause_of_undoing"]


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
            return Attribution(cause, command.order.id, None if command.is_raw else role)
        if role is ReportRole.OTHERWISE and fact.at <= command.ended_at:
            answered = Attribution(Cause.PERSON, command.order.id, role)
    if fact.value is None or fact.is_first or fact.is_after_loss:
        return _NOT_KNOWN
    if fact.along:
        return Attribution(Cause.COMMAND, fact.along) if fact.is_usual else _NOT_KNOWN
    if fact.timed >= ENOUGH:
        return _TIMED
    if fact.timed and fact.at - fact.since > durations.HASTY:
        return _NOT_KNOWN
    return answered


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
    if role is ReportRole.AGREES and (command.is_open or fact.at - _last_sign(command) <= durations.CAME_ALONG):
        return Cause.COMMAND
    if role is ReportRole.ASIDE and _rests_where_sent(fact, command):
        return Cause.COMMAND
    return None


def _rests_where_sent(fact: Reported, command: CommandProgress) -> bool:
    """Return whether a cover arrived: halfway it reports open, stopped, or closed until it reports its position."""
    return fact.value in _RESTS and any(abs(fact.at - met) <= durations.CAME_ALONG for met in command.met_times)


def _last_sign(command: CommandProgress) -> float:
    """Return the time of the last sign that the command was in progress."""
    moved_at = -float("inf") if command.moved_at is None else command.moved_at
    return max(command.sent_at, moved_at, *command.met_times, *command.accepted.values(), command.given_at)
