"""Commands of a recording that a replay gives again, matched by content and time. Pure."""

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from typing import Final, TypeAlias, cast, final

from homebot.devices.value import PlainValue
from homebot.devices.wording.journal_words import issuer_text, name_text, settings_text, trigger_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.messages.json import message_to_json
from homebot.recording.lines import RecordedCommand
from homebot.recording.recording import TimedCommand
from homebot.support.printable import printable

TOLERANCE: Final = 1.0
"""Seconds by which the same command may be earlier or later on a busy computer, without people noticing."""

ROUNDED: Final = 1e-6

CommandKey: TypeAlias = "tuple[str, str, str, str, tuple[tuple[str, PlainValue], ...]]"


def is_carried_out(given: TimedCommand) -> bool:
    """Return whether a command was allowed to be sent: no policy or lease refused it."""
    return given.result is None or given.result.policy in {"", "gateway"}


@final
class CommandMatcher:
    """Finds the same command among others: with the same issuer, part and values, at most 1 s apart.

    Each is found once, the earliest first. Commands that a policy refused are ignored.
    """

    def __init__(self, commands: Iterable[TimedCommand]) -> None:
        self._left: defaultdict[CommandKey, list[TimedCommand]] = defaultdict(list)
        for command in commands:
            if is_carried_out(command):
                self._left[command_key(command.command)].append(command)

    def pop(self, wanted: TimedCommand) -> TimedCommand | None:
        """Remove and return the same command as *wanted*; None if there is none."""
        same = self._left.get(command_key(wanted.command), [])
        number = bisect_left(same, wanted.at - TOLERANCE - ROUNDED, key=lambda one: one.at)
        if number < len(same) and same[number].at <= wanted.at + TOLERANCE + ROUNDED:
            return same.pop(number)
        return None

    @property
    def left(self) -> list[TimedCommand]:
        """The commands that were not found."""
        return [command for same in self._left.values() for command in same]


def command_key(command: RecordedCommand) -> CommandKey:
    """Return the key of a command: equal for the same command of two runs."""
    settings = tuple((setting.capability, setting.value.plain()) for setting in command.settings)
    return command.issuer, command.device, command.part, command.text, settings


def command_text(given: TimedCommand, start: float, names: Mapping[str, str]) -> str:
    """Return a command as a line: time, device, setting, issuer and cause.

    Args:
        start: When the recording began, in seconds since the Unix epoch.
        names: As returned by :func:`homebot.devices.device.part_names`.
    """
    command = cast("RecordedCommand", JsonMessage(message_to_json(given.command)))
    local = datetime.fromtimestamp(start + given.at, UTC).astimezone()
    what = printable(command.text) or settings_text(command.settings)
    cause = trigger_text(command.trigger, names)
    because = f", because {cause}" if cause else ""
    outcome = f" ({printable(given.result.text)})" if given.result is not None else ""
    stamp = f"{local:%Y-%m-%d %H:%M:%S}"
    return f"{stamp}  {device_text(given, names)}  {what}  {issuer_text(command.issuer)}{because}{outcome}"


def device_text(given: TimedCommand, names: Mapping[str, str]) -> str:
    """Return the name of the device and part of a command."""
    return name_text(given.command.device, names, given.command.part)
