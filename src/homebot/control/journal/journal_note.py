"""A note for the journal; the entry is made of it when somebody reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from homebot.devices.journal_messages import JournalEntry
from homebot.devices.trigger import NO_TRIGGER
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.devices.command_messages import CommandResult, Setting
    from homebot.devices.journal_messages import EntryKind, JournalVerdict
    from homebot.devices.trigger import Trigger

__all__ = ["JournalNote"]


@final
@dataclass(slots=True)
class JournalNote:
    """An entry to be: a command has five, of which mostly nobody reads any.

    The attributes are those of `JournalEntry`, but for *at*, which is in seconds since the Unix epoch.
    """

    kind: EntryKind
    at: float
    device: str
    part: str = ""
    command: str = ""
    issuer: str = ""
    trigger: Trigger = NO_TRIGGER
    settings: tuple[Setting, ...] = ()
    text: str = ""
    verdicts: tuple[JournalVerdict, ...] = ()
    results: tuple[CommandResult, ...] = ()
    folded: int = 0

    @property
    def stamp(self) -> Time:
        """The time as the entry has it, to the nanosecond."""
        return Time.from_seconds(self.at)

    def entry(self) -> JournalEntry:
        """Return the entry; each call makes a new one."""
        return JournalEntry(
            kind=self.kind,
            at=self.stamp,
            device=self.device,
            part=self.part,
            command=self.command,
            issuer=self.issuer,
            trigger=self.trigger,
            settings=self.settings,
            text=self.text,
            verdicts=self.verdicts,
            results=self.results,
            folded=self.folded,
        )
