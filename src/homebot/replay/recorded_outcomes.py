"""Outcomes of commands in a replay: those of the recording; of a command that it does not have, success. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import ClassVar, final

from homebot.control.command import IssuedCommand
from homebot.devices.command_messages import Setting
from homebot.devices.outcomes import Confirmed, Evidence, Outcome
from homebot.devices.value import Value
from homebot.recording.lines import RecordedCommand
from homebot.recording.recording import TimedCommand
from homebot.replay.command_diff import CommandMatcher

__all__ = ["RecordedOutcomes"]


@final
class RecordedOutcomes:
    """Answers commands as the devices did that were recorded.

    A command of the recording that was sent goes to the muted gateway, and its outcome follows from the reports that
    were recorded; one that was not sent then, because the device was so already or its network was away, ends as it did
    then. A command that is not in the recording counts as sent and obeyed for the app that gave it, until the device
    reports next; for all others the states of devices stay those of the recording.

    Args:
        commands: The commands of the recording, in the order of time.
        now: Returns seconds since the start of the recording.
    """

    is_live: ClassVar[bool] = False

    def __init__(self, commands: Iterable[TimedCommand], now: Callable[[], float]) -> None:
        self._matcher = CommandMatcher(commands)
        self._now = now

    def outcome(self, command: IssuedCommand) -> Outcome | None:
        """Return the outcome; see :class:`homebot.control.rehearsal.Rehearsal`."""
        found = self._matcher.pop(TimedCommand(self._now(), _recorded(command)))
        if found is None:
            return Confirmed(0.0, Evidence.SENT, command_id=command.id)
        if found.result is None:
            return None
        outcome = replace(found.result.to_outcome(), command_id=command.id)
        return None if outcome.was_sent else outcome


def _recorded(command: IssuedCommand) -> RecordedCommand:
    settings = tuple(Setting(capability=name, value=Value.of(value)) for name, value in command.settings.items())
    return RecordedCommand(
        id=command.id, issuer=command.issuer, device=command.device.id, part=command.part.id, settings=settings
    )
