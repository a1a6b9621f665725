"""Rehearsals: commands are checked and recorded, and reach no device. Pure."""

from __future__ import annotations

from typing import ClassVar, Final, Protocol, final

from homebot.control.command import IssuedCommand
from homebot.devices.outcomes import Confirmed, Evidence, Outcome, Refused

__all__ = ["DRY_RUN", "DryRun", "Rehearsal"]

DRY_RUN: Final = "dry_run"
"""The policy that refuses the commands of people in a dry run."""


class Rehearsal(Protocol):
    """Answers commands that are not to be sent.

    Attributes:
        is_live: Whether the devices are real, so that a raw command has no effect; a replay has its recorded effect.
    """

    is_live: ClassVar[bool]

    def outcome(self, command: IssuedCommand) -> Outcome | None:
        """Return the assumed outcome of *command*; None to send it to a muted gateway."""
        ...


@final
class DryRun:
    """A dry run: nothing is sent.

    An app continues as if the device had obeyed, until the next report. A person gets a refusal.
    """

    is_live: ClassVar[bool] = True

    def outcome(self, command: IssuedCommand) -> Outcome:
        """Return the outcome; see :class:`Rehearsal`."""
        if command.is_client:
            problem = "homebot runs with --dry-run and sends nothing; otherwise it would have sent this"
            return Refused(DRY_RUN, problem, command_id=command.id)
        return Confirmed(0.0, Evidence.SENT, command_id=command.id)
