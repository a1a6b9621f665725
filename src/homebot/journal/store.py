"""Store of the journal and the device profiles: its rows, and the store in memory."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple, final

from homebot.devices.command_messages import CommandResult
from homebot.devices.journal_messages import MAX_ENTRIES, JournalEntry, ReadJournalRequest, ReadJournalResponse
from homebot.devices.trigger import NO_TRIGGER
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.devices.command_messages import Setting
    from homebot.devices.journal_messages import EntryKind, JournalVerdict
    from homebot.devices.outcomes import Outcome
    from homebot.devices.trigger import Trigger

_SHARE: Final = 0.1
"""The share of the largest issuer's entries that is dropped at once; see :mod:`.journal_file`."""


@final
class JournalNote(NamedTuple):
    """The fields of a `JournalEntry`, which is only built when it is read, because few are.

    Attributes:
        at: Seconds since the Unix epoch.
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
    outcome: Outcome | None = None
    cause: str = ""
    folded: int = 0

    @property
    def stamp(self) -> Time:
        """The time in the form of the entry, to the nanosecond."""
        return Time.from_seconds(self.at)

    def entry(self) -> JournalEntry:
        """Return a new entry."""
        results = () if self.outcome is None else (CommandResult.of(self.outcome),)
        same = {name: value for name, value in self._asdict().items() if name != "outcome"}
        return JournalEntry(**{**same, "at": self.stamp, "results": results})


class LearntRow(NamedTuple):
    """A saved record of the knowledge about devices.

    Attributes:
        kind: Such as ``profile``.
        name: Its name, unique in its kind.
        record: The record as text; empty to remove it.
        at: When it was last learnt, in seconds since the Unix epoch.
    """

    kind: str
    name: str
    record: str
    at: float


class JournalStore:
    """In-memory store of entries, in the order in which they are added, and of learnt rows.

    Entries are dropped when they are too old, and the largest issuer's oldest ones when there are too many.

    Args:
        longest: Seconds for which an entry is stored.

    Attributes:
        dropped: Entries that were dropped because they were too many or too old.
        failures: Entries, and rows, that could not be stored.
        remembers: Whether it may contain rows of an earlier run.
    """

    def __init__(self, most: int, longest: float) -> None:
        self._entries: deque[JournalNote] = deque()
        self._most = most
        self._longest = longest
        self.dropped = 0
        self.failures = 0
        self.remembers = False

    @property
    def problem(self) -> str:
        """The problem of the store, as text; empty if there is none."""
        return ""

    def add(self, note: JournalNote) -> None:
        """Add an entry; never blocks or does I/O."""
        entries = self._entries
        entries.append(note)
        oldest = note.at - self._longest
        while entries[0].at < oldest:
            entries.popleft()
            self.dropped += 1
        if len(entries) > self._most:
            # the issuer with the most entries loses the oldest of them
            ((issuer, count),) = Counter(waiting.issuer for waiting in self._entries).most_common(1)
            excess = max(1, round(_SHARE * count))
            self.dropped += excess
            kept: deque[JournalNote] = deque()
            for waiting in self._entries:
                if excess and waiting.issuer == issuer:
                    excess -= 1
                else:
                    kept.append(waiting)
            self._entries = kept

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit, including those added a moment ago."""
        return with_newer(ReadJournalResponse(), self._entries, request)

    def learn(self, row: LearntRow) -> None:
        """Replace the row of the same kind and name, or remove it if *row* has no record; never blocks.

        The in-memory store does nothing: the knowledge ends with the run.
        """

    async def learnt(self) -> tuple[LearntRow, ...]:
        """Return the rows of earlier runs, the least recently used first; an unreadable row has no record."""
        return ()

    async def run(self) -> None:
        """Write until cancelled; the in-memory store does nothing."""

    async def close(self) -> None:
        """Write the rest and close, within a few seconds; nothing is added afterwards."""


def with_newer(
    response: ReadJournalResponse, notes: Sequence[JournalNote], request: ReadJournalRequest
) -> ReadJournalResponse:
    """Return *response* with the newer *notes*, oldest first, that fit *request*."""
    if not notes or not response.success:
        return response
    limit = min(request.limit or MAX_ENTRIES, MAX_ENTRIES)
    newer = list(islice(_newest_fitting(notes, request), limit + 1))
    entries = (*response.entries, *(note.entry() for note in reversed(newer)))
    begins = response.begins if response.begins.to_seconds() else notes[0].stamp
    is_complete = response.complete and len(entries) <= limit
    return ReadJournalResponse(entries=entries[-limit:], complete=is_complete, begins=begins)


def _newest_fitting(notes: Sequence[JournalNote], request: ReadJournalRequest) -> Iterator[JournalNote]:
    """Yield the *notes* that fit *request*, newest first; *notes* are oldest first."""
    since, until = request.since.to_seconds(), request.until.to_seconds()
    device, devices, command = request.device, request.devices, request.command
    for note in reversed(notes):  # one that is too old is not the end: the clock may have been set
        if (
            (not device or device == note.device)
            and (not devices or note.device in devices)
            and (not command or command == note.command)
            # rounded as in the entries, which a request may quote
            and since <= (at := note.stamp.to_seconds())
            and (not until or at <= until)
        ):
            yield note
