"""Commands and leases for a recording, from the entries of the journal. Pure."""

from __future__ import annotations

from typing import Final, final

from homebot.devices.command_messages import CommandResult
from homebot.devices.journal_messages import JournalEntry
from homebot.recording.lines import LeaseNews, RecordedCommand
from homebot.recording.secrets import without_secrets
from homebot.support.bounded_map import BoundedMap

__all__ = ["CommandNews"]


_MOST: Final = 1_000
"""Commands that are known at once: the entries about one text follow each other."""


@final
class CommandNews:
    """Reads commands, their outcomes and leases from the journal.

    A text of an app appears there as the parsed command, and then as published.
    """

    def __init__(self) -> None:
        self._requested: BoundedMap[str, None] = BoundedMap(_MOST)

    def of(self, entry: JournalEntry) -> RecordedCommand | CommandResult | LeaseNews | None:
        """Return the command that *entry* begins, the outcome or the step of a lease that it has; None for others."""
        match entry.kind:
            case "requested":
                self._requested[entry.command] = None
                return _command(entry)
            case "published" if entry.command not in self._requested:
                return _command(entry)
            case "outcome":
                return entry.results[0]
            case "held" | "released" | "ended" | "expired" as step:
                return LeaseNews(
                    step=step,
                    device=entry.device,
                    part=entry.part,
                    setting=entry.settings[0],
                    issuer=entry.issuer,
                    by=entry.text,
                )
        return None


def _command(entry: JournalEntry) -> RecordedCommand:
    return RecordedCommand(
        id=entry.command,
        issuer=entry.issuer,
        device=entry.device,
        part=entry.part,
        settings=entry.settings,
        text=without_secrets(entry.text.encode()).decode(errors="replace"),
        trigger=entry.trigger,
    )
