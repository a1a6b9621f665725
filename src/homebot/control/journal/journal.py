"""Journal of a home: each step of each command is published and stored, and a service reads them."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from itertools import count
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, final

from homebot.control.journal.command_log import CommandChain, CommandLog
from homebot.control.journal.given_codes import CODE_GIVEN, MAX_NOTED_CHARACTERS, is_for_code, public_text
from homebot.control.timeline.facts import PartRef
from homebot.devices import Device, RawCommand
from homebot.devices.client_rights import CLIENT_RIGHTS
from homebot.devices.command_messages import Setting
from homebot.devices.device import KeyValue, part_names
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.health import Count, HealthResponse
from homebot.devices.journal_messages import (
    EntryKind,
    JournalEntry,
    JournalFact,
    JournalVerdict,
    ReadJournalRequest,
    ReadJournalResponse,
)
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.query.terms import FactIs, Or
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue, Value
from homebot.devices.wording.time_format import ago
from homebot.graph import Node
from homebot.journal.entry_aggregation import EntryAggregation
from homebot.journal.store import JournalNote, with_newer
from homebot.messages import Time
from homebot.support.counters import Severity

if TYPE_CHECKING:
    from homebot.control.command import IssuedCommand
    from homebot.control.policies import Verdict
    from homebot.devices.access_messages import AccessRefused
    from homebot.devices.lease_messages import HoldRequest
    from homebot.devices.outcomes import Outcome, Reverted
    from homebot.journal.store import JournalStore

LeaseStep: TypeAlias = Literal["held", "released", "ended", "expired", "outranked", "handed_back"]

_DEPTH = 1000
_MAX_NAMES = 500
_ENDS: Final = frozenset({"published", "outcome"})
"""Kinds of entries that end a command."""

_MAX_UNFILED_S: Final = 30.0
"""The most seconds after which the first entries of a command are filed, although it has no outcome."""

_MAX_OPEN: Final = 10_000


@final
class CommandJournal:
    """Publishes and stores the entries.

    An entry is published, and can be read, at once. Those of a command are filed in the store together, at its outcome
    or when homebot stops. A command that has no outcome within half a minute is filed as far as it is known, so a crash
    may lose its later entries, but not that it was given.
    """

    def __init__(self, node: Node, store: JournalStore, lookup: DeviceLookup) -> None:
        self._clock = node.graph.clock
        self._ids = map(f"{round(self._clock.now()):x}-{{}}".format, count(1))
        self._store = store
        self._folding = EntryAggregation()
        self._open: dict[str, CommandChain] = {}
        self._is_timed = False
        self.log = CommandLog(node, lookup)
        self.fights = self.log.fights
        self._lookup = lookup
        self._entries = node.create_publisher(JournalEntry, JOURNAL_ENTRIES, _DEPTH)

    async def run(self) -> None:
        """Write entries until cancelled."""
        await self._store.run()

    async def close(self) -> None:
        """Write the last entries, even when cancelled."""
        self.log.write()
        for left in self._waiting():
            self._store.add(left)
        await self._store.close()

    def health(self, counts: Mapping[str, int], notes: tuple[str, ...]) -> HealthResponse:
        """Return the counters and problems of the journal, after the *counts* of others, and with *notes*."""
        store, now = self._store, self._clock.now()
        failures = Count(name="journal_failures", count=store.failures, severity=Severity.LOSS)
        return HealthResponse(
            counts=(Count(name="journal_expired", count=store.dropped), failures, *Count.each(counts)),
            notes=notes,
            troubles=(
                *((store.problem,) if store.problem else ()),
                *(
                    f"{fight.text}, the last {ago(fight.newest, now)}; see homebot why {fight.device}"
                    for fight in self.fights.recent(now)
                ),
            ),
        )

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit, and the names of their devices."""
        response = with_newer(await self._store.read(request), self._waiting(), request)
        entries = tuple(sorted(response.entries, key=lambda one: one.at.to_seconds()))  # folded ones are stored late
        ids = sorted({place for entry in entries for place in (entry.device, entry.trigger.device) if place})
        wanted = Or(tuple(FactIs("id", device_id.casefold()) for device_id in ids[:_MAX_NAMES]))
        devices = await self._lookup.all_known(wanted) if ids else ()  # none if the directory does not answer
        names = tuple(KeyValue(key=key, value=name) for key, name in part_names(devices).items() if name)
        return response.model_copy(update={"entries": entries, "names": names})

    def record_request(
        self,
        issuer: str,
        place: PartRef,
        settings: tuple[Setting, ...],
        trigger: Trigger,
        at: float,
        device: Device | None,
    ) -> str:
        """Record a command to the part *place* at *at*, in seconds since the Unix epoch; return its new id.

        Args:
            settings: The wanted values, without codes.
        """
        name = next(self._ids)
        note = JournalNote("requested", at, *place, name, issuer, trigger, settings)
        self._open[name] = CommandChain([note], device)
        if not self._is_timed:
            self._is_timed = True
            asyncio.get_running_loop().call_later(_MAX_UNFILED_S, self._file_open)
        if self._entries.subscription_count:
            self._entries.publish(note.entry())
        return name

    def record(
        self, kind: EntryKind, command: IssuedCommand, text: str = "", verdicts: tuple[JournalVerdict, ...] = ()
    ) -> None:
        """Record a step of *command*."""
        now, (device, part) = self._clock.now(), command.place
        self._add(JournalNote(kind, now, device, part, command.id, command.issuer, NO_TRIGGER, (), text, verdicts))

    def record_verdict(self, command: IssuedCommand, verdict: Verdict) -> None:
        """Record the verdict of a policy."""
        facts = tuple(
            JournalFact(name=fact.name, value=Value.of(fact.value), since=Time.from_seconds(fact.since))
            for fact in verdict.facts
        )
        noted = JournalVerdict(policy=verdict.policy, allowed=verdict.allowed, reason=verdict.reason, facts=facts)
        self.record("judged", command, verdicts=(noted,))

    def record_report(
        self, place: PartRef, setting: Setting, at: float, cause: str, command: str = "", issuer: str = ""
    ) -> None:
        """Record a report of the part *place* at its own time.

        Args:
            cause: The cause of a change; empty for none.
            command: The id of the command behind it; empty for none.
        """
        kind: EntryKind = "reported" if command else "changed"
        self._add(JournalNote(kind, at, *place, command, issuer, settings=(setting,), cause=cause))

    def record_outcome(self, issuer: str, place: PartRef, outcome: Outcome) -> None:
        """Record the outcome of a command of *issuer* to the part *place*."""
        self._add(JournalNote("outcome", self._clock.now(), *place, outcome.command_id, issuer, outcome=outcome))

    def record_revert(self, issuer: str, place: PartRef, outcome: Reverted, setting: Setting) -> None:
        """Record that another *setting* followed the one that a command of *issuer* to the part *place* brought."""
        now, name = self._clock.now(), outcome.command_id
        note = JournalNote(
            "reverted", now, *place, name, issuer, settings=(setting,), outcome=outcome, cause=outcome.cause
        )
        self._add(note)

    def record_sent(
        self, device: str, command: RawCommand, at: float, *, is_sent: bool = True, is_code: bool = False
    ) -> str:
        """Record a raw command to a device at *at*, in seconds since the Unix epoch; return its id.

        Args:
            is_sent: Whether the gateway sends it.
            is_code: Whether its text is a code, which is not recorded.
        """
        name = command.command_id or next(self._ids)
        text = CODE_GIVEN if is_code else command.payload
        if not text.isalpha() or is_for_code(command.address):  # a word such as "on" is not a code
            text = public_text(text, command.address)
        text = text[:MAX_NOTED_CHARACTERS]
        self._add(
            JournalNote("published", at, device, "", name, issuer=command.issuer, trigger=command.trigger, text=text)
        )
        if not is_sent:
            self._add(JournalNote("would", at, device, "", name, issuer=command.issuer))
        return name

    def record_denial(self, refused: AccessRefused, device: str, count: int) -> None:
        """Record that the door refused *count* requests such as this one, to *device* if it is known."""
        facts: dict[str, PlainValue] = {
            "operation": refused.operation,
            "target": refused.target,
            "right": refused.right,
            "address": refused.address,
            "count": float(count),
        }
        verdict = JournalVerdict(
            policy=CLIENT_RIGHTS,
            allowed=False,
            reason=refused.reason,
            facts=tuple(JournalFact(name=name, value=Value.of(value)) for name, value in facts.items()),
        )
        at = refused.refused_at.to_seconds()
        self._add(JournalNote("denied", at, device, issuer=refused.issuer, text=refused.wanted, verdicts=(verdict,)))

    def hold_denied(self, request: HoldRequest, policy: str, reason: str) -> None:
        """Record that *request* was refused before any command."""
        self._add(
            JournalNote(
                "denied",
                self._clock.now(),
                request.device,
                request.part,
                issuer=request.issuer,
                trigger=request.trigger,
                settings=(request.setting,),
                text=request.by,
                verdicts=(JournalVerdict(policy=policy, allowed=False, reason=reason),),
            )
        )

    def lease(
        self, kind: LeaseStep, place: PartRef, held: Setting, issuer: str, text: str, trigger: Trigger = NO_TRIGGER
    ) -> None:
        """Record a step of a lease on the part *place*."""
        self._add(JournalNote(kind, self._clock.now(), *place, "", issuer, trigger, (held,), text))

    def goal(self, device: str, issuer: str, text: str) -> None:
        """Record an act of a goal of *issuer* with the device other than by commands, as *text* says."""
        self._add(JournalNote("goal", self._clock.now(), device, issuer=issuer, text=text))

    def _add(self, note: JournalNote) -> None:
        if self._entries.subscription_count:
            self._entries.publish(note.entry())
        command = self._open.get(note.command)
        if command is None:
            command = CommandChain([note])
        else:
            command.notes.append(note)
            if note.kind not in _ENDS:
                return
            del self._open[note.command]
        if note.kind in _ENDS:
            self.log.end(command)
        self._file(command)

    def _file(self, command: CommandChain) -> None:
        for kept in self._folding.add(command.notes[command.filed :]):
            self._store.add(kept)
        command.filed = len(command.notes)

    def _file_open(self) -> None:
        """File the facts of the open commands, so that a crash loses their outcome at most."""
        self._is_timed = False
        for command in self._open.values():
            if not command.filed:
                self._file(command)
        while len(self._open) > _MAX_OPEN:
            del self._open[next(iter(self._open))]

    def _waiting(self) -> list[JournalNote]:
        """Return the entries that are not stored yet, oldest first."""
        unfiled = [note for command in self._open.values() for note in command.notes[command.filed :]]
        return sorted((*self._folding.waiting(), *unfiled), key=lambda note: note.at)
