"""Commands of a replay, and their differences, in words and as JSON. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import cast

from homebot.cli.command_records import SettingRecord, TriggerRecord
from homebot.cli.journal_words import issuer_text, name_text, settings_text, trigger_text
from homebot.cli.table import printable
from homebot.messages.json import message_to_json
from homebot.recording.recording import TimedCommand
from homebot.replay.command_diff import CommandDiff, DifferentCommand

__all__ = ["command_json", "command_text", "difference_json", "difference_text", "summary_text"]

_SIGNS = {"added": "+", "gone": "-"}


def command_text(given: TimedCommand, start: float, names: Mapping[str, str]) -> str:
    """Return a command as a line: when, which device, what, who and why.

    Args:
        given: The command.
        start: When the recording began, in seconds since the Unix epoch.
        names: As :func:`homebot.devices.part_names.part_names` gives them.
    """
    command = given.command
    local = datetime.fromtimestamp(start + given.at, UTC).astimezone()
    what = printable(command.text) or settings_text(_settings(given))
    cause = trigger_text(_trigger(given), names)
    because = f", because {cause}" if cause else ""
    outcome = f" ({printable(given.result.text)})" if given.result is not None else ""
    stamp = f"{local:%Y-%m-%d %H:%M:%S}"
    return f"{stamp}  {_name(given, names)}  {what}  {issuer_text(command.issuer)}{because}{outcome}"


def difference_text(one: DifferentCommand, start: float, names: Mapping[str, str]) -> str:
    """Return a difference as a line that begins with ``+`` or ``-``."""
    where = "in the replay" if one.kind == "gone" else "in the recording"
    refused = f"; refused {where} by {printable(one.refused)}" if one.refused else ""
    return f"{_SIGNS[one.kind]} {command_text(replace(one.given, result=None), start, names)}{refused}"


def summary_text(diff: CommandDiff) -> str:
    """Return the numbers of a diff as a sentence."""
    added = sum(one.kind == "added" for one in diff.different)
    gone = len(diff.different) - added
    if not diff.different:
        return f"no difference: {'1 command is' if diff.same == 1 else f'{diff.same:,} commands are'} the same"
    return f"{added:,} added, {gone:,} gone, {diff.same:,} the same"


def command_json(given: TimedCommand, start: float, names: Mapping[str, str]) -> dict[str, object]:
    """Return a command for programs; arguments as for :func:`command_text`."""
    command = given.command
    record = message_to_json(command)
    return {
        "at": datetime.fromtimestamp(start + given.at, UTC).isoformat(timespec="milliseconds"),
        "name": _name(given, names),
        "because": trigger_text(_trigger(given), names),
        **{key: value for key, value in record.items() if key not in {"id", "trigger"}},
        "outcome": "" if given.result is None else given.result.outcome,
    }


def difference_json(one: DifferentCommand, start: float, names: Mapping[str, str]) -> dict[str, object]:
    """Return a difference for programs."""
    return {"difference": one.kind, "refused": one.refused, **command_json(one.given, start, names)}


def _name(given: TimedCommand, names: Mapping[str, str]) -> str:
    return name_text(given.command.device, names, given.command.part)


def _settings(given: TimedCommand) -> list[SettingRecord]:
    return [cast("SettingRecord", message_to_json(one)) for one in given.command.settings]


def _trigger(given: TimedCommand) -> TriggerRecord:
    return cast("TriggerRecord", message_to_json(given.command.trigger))
