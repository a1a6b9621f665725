"""Recent outcomes of commands by device: one that often fails is not the right one."""

from dataclasses import dataclass
from typing import Final, final

from homebot.devices.journal_messages import MAX_ENTRIES, JournalEntry, ReadJournal, ReadJournalRequest
from homebot.devices.names import JOURNAL_ENTRIES, READ_JOURNAL
from homebot.devices.outcomes import OUTCOMES
from homebot.discovery.search.near_rank import CostTerm
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.messages import Time

_HALF_LIFE: Final = 7 * 86_400.0
_BACK: Final = 3 * _HALF_LIFE
"""How far outcomes count, in seconds; the oldest weigh an eighth."""

_MAX_PAGES: Final = 20
_WORST: Final = 6.0
"""Metres added to a device whose commands always fail."""


@dataclass(slots=True)
class _Tally:
    """The numbers of commands and failures, and their sums weighted by age."""

    commands: int = 0
    failures: int = 0
    weight: float = 0.0
    succeeded: float = 0.0


@final
class PastOutcomes:
    """The outcomes of the last three weeks: from the journal at first, then live."""

    def __init__(self, node: Node) -> None:
        self._clock = node.graph.clock
        self._begin = self._clock.now()
        self._tallies: dict[str, _Tally] = {}
        self._read = node.create_client(ReadJournal, READ_JOURNAL)
        node.create_subscription(JournalEntry, JOURNAL_ENTRIES, self._add, 1000)
        node.create_task(self._load)

    def term(self, device_id: str) -> tuple[CostTerm, ...]:
        """Return the cost of a device's past outcomes; nothing while no device has any."""
        if not self._tallies:
            return ()
        known = self._tallies.get(device_id)
        if known is None:
            return (CostTerm(_WORST / 10, "no command was tried lately"),)
        age = 2.0 ** ((self._begin - self._clock.now()) / _HALF_LIFE)
        expected = (known.succeeded * age + 9) / (known.weight * age + 10)
        reason = f"{known.failures} of {known.commands} commands failed lately"
        return (CostTerm(_WORST * (1 - expected), reason),)

    async def _load(self) -> None:
        """Read the journal, newest entries first; without one nothing is known."""
        until = Time.from_seconds(self._begin)
        since = Time.from_seconds(self._begin - _BACK)
        seen: set[JournalEntry] = set()
        for _ in range(_MAX_PAGES):
            request = ReadJournalRequest(since=since, until=until, limit=MAX_ENTRIES)
            try:
                page = await self._read.call(request)
            except ServiceError:
                return
            new = [entry for entry in page.entries if entry not in seen]
            for entry in new:
                self._add(entry)
            if page.complete or not new:
                return
            seen, until = set(page.entries), page.entries[0].at

    def _add(self, entry: JournalEntry) -> None:
        if entry.kind not in {"outcome", "reverted"} or not entry.results:
            return
        outcome = OUTCOMES[entry.results[0].outcome]
        if not outcome.judges_device:
            return
        tally = self._tallies.setdefault(entry.device, _Tally())
        weight = 2.0 ** ((entry.at.to_seconds() - self._begin) / _HALF_LIFE)
        if entry.kind == "reverted":  # after a success
            if entry.cause in {"person", "program"}:
                return
            tally.succeeded -= weight
            tally.failures += 1
            return
        tally.commands += 1
        tally.weight += weight
        tally.succeeded += weight if outcome.succeeded else 0.0
        tally.failures += not outcome.succeeded
