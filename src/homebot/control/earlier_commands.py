"""Commands of an earlier run that devices may obey yet, by the newest entries of the journal. Pure."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from homebot.control.timeline.facts import PartRef
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.outcomes import NoAnswer, Outcome
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import related

_UNKNOWN: Final = NoAnswer(0.0)
_REPORTS: Final = frozenset({"reported", "changed"})


@dataclass(slots=True)
class EarlierCommand:
    """Command of an earlier run; times are in seconds since the Unix epoch.

    Attributes:
        sent_at: When each of its sendings began.
        is_open: Whether its outcome is not known.
        ended_at: When it was; the newest sending of an open command.
    """

    id: str
    issuer: str
    settings: dict[str, PlainValue]
    sent_at: list[float] = field(default_factory=list)
    outcome: Outcome = _UNKNOWN
    is_open: bool = True
    ended_at: float = 0.0


def _time_of(entry: JournalEntry) -> float:
    return entry.at.to_seconds()


def commands_in_doubt(entries: Iterable[JournalEntry]) -> dict[PartRef, list[EarlierCommand]]:
    """Return by part the commands that may have had an effect although no report says so, oldest first.

    Those that were open have no answer. A later report of the same thing, or a later command for it that succeeded,
    ends the doubt.
    """
    parts: defaultdict[PartRef, dict[str, EarlierCommand]] = defaultdict(dict)
    for entry in sorted(entries, key=_time_of):  # those of a command are stored with its outcome
        commands, at = parts[entry.device, entry.part], _time_of(entry)
        command = commands.get(entry.command)
        if entry.kind == "requested":
            settings = {setting.capability: setting.value.plain() for setting in entry.settings}
            commands[entry.command] = EarlierCommand(entry.command, entry.issuer, settings)
        elif entry.kind == "sent" and command is not None:
            command.sent_at.append(at)
            command.ended_at = at
        elif entry.kind == "outcome" and command is not None:
            command.outcome, command.is_open, command.ended_at = entry.results[0].to_outcome(), False, at
            if command.outcome.succeeded:
                _end_doubt(commands, command.settings)
            elif not command.outcome.may_obey_later:
                del commands[command.id]
        elif entry.kind in _REPORTS:
            _end_doubt(commands, [setting.capability for setting in entry.settings])
    sent = {place: [command for command in commands.values() if command.sent_at] for place, commands in parts.items()}
    return {place: commands for place, commands in sent.items() if commands}


def _end_doubt(commands: dict[str, EarlierCommand], capabilities: Iterable[str]) -> None:
    """Remove from *commands* those with an outcome that concern one of *capabilities*."""
    names = {other for name in capabilities for other in related(name)}
    for command in tuple(commands.values()):
        if not (command.is_open or names.isdisjoint(command.settings)):
            del commands[command.id]
