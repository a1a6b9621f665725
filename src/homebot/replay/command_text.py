"""A recorded command as a line."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import cast

from homebot.devices.wording.journal_words import issuer_text, name_text, settings_text, trigger_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.messages.json import message_to_json
from homebot.recording.lines import RecordedCommand
from homebot.recording.recording import TimedCommand
from homebot.support.printable import printable


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
