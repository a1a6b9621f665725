"""The journal of a home: takes each step of each command, publishes it, keeps it, and is read by a service."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import TYPE_CHECKING, Literal, TypeAlias, final

import anyio

from homebot.control.journal.command_folding import CommandFolding
from homebot.control.journal.given_codes import CODE_GIVEN, is_for_code, public_text
from homebot.control.journal.house_changes import HouseChanges
from homebot.control.journal.journal_note import JournalNote
from homebot.control.journal.memory_store import with_newer
from homebot.devices import FIND_DEVICES, FindDevices, RawCommand
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.device import ChangedSetting, KeyValue, part_names
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
from homebot.devices.query import Or, query_terms
from homebot.devices.query.terms import FactIs
from homebot.devices.services import FindDevicesRequest
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue, Value
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.control.command import IssuedCommand
    from homebot.control.journal.store import JournalStore
    from homebot.control.policies import Verdict
    from homebot.devices.access_messages import AccessRefused
    from homebot.devices.lease_messages import HoldRequest

__all__ = ["CommandJournal", "LeaseStep"]

LeaseStep: TypeAlias = Literal["held", "released", "ended", "expired", "outranked", "handed_back"]

_Part: TypeAlias = tuple[str, str]
"""The ids of a device and of one of its parts."""

_DEPTH = 1000
_SHORTEST_SETTLE = 2.0
"""Seconds after a command at least: the directory tells of a change a little later than the gateway."""


_MOST_NAMES = 500
_LONGEST = 500


@final
class CommandJournal:
    """Takes the entries.

    Args:
        node: The node that publishes them and serves the reading.
        store: Keeps them.
        changes: Receives the raw commands, which explain changes.
        settle: Seconds after a raw command in which a change of the device is taken for its effect.

    Attributes:
        store: Keeps them, and what is learnt from commands.
    """

    def __init__(self, node: Node, store: JournalStore, changes: HouseChanges, settle: float) -> None:
        self._clock = node.graph.clock
        self._changes = changes
        self._settle = max(settle, _SHORTEST_SETTLE)
        self._ids = map(f"{round(self._clock.now()):x}-{{}}".format, count(1))
        self.store = store
        self._folding = CommandFolding()
        self._counters: dict[str, Callable[[], int]] = {}
        self._last_notes: list[Callable[[], None]] = []
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._entries = node.create_publisher(JournalEntry, JOURNAL_ENTRIES, _DEPTH)

    async def run(self) -> None:
        """Write what is noted until cancelled, then the last notes."""
        try:
            await self.store.run()
            await anyio.sleep_forever()
        finally:
            for note in self._last_notes:
                note()
            for left in self._folding.close():
                self.store.add(left)
            await self.store.close()

    def add_last_note(self, note: Callable[[], None]) -> None:
        """Call *note* when the journal ends, to note what was not noted until then."""
        self._last_notes.append(note)

    def add_counter(self, name: str, read: Callable[[], int]) -> None:
        """Show in the health of the node what *read* returns, as *name*."""
        self._counters[name] = read

    def health(self) -> HealthResponse:
        """Return what became of the entries, and the further counters."""
        store = self.store
        counts = {"journal_expired": store.dropped, "journal_failures": store.failures}
        counts |= {name: read() for name, read in self._counters.items()}
        return HealthResponse(
            counts=Count.each(counts),
            troubles=(store.problem,) if store.problem else (),
        )

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit, and the names of their devices."""
        response = with_newer(await self.store.read(request), self._folding.waiting(), request)
        ids = {one.device for one in response.entries} | {one.trigger.device for one in response.entries}
        return response.model_copy(update={"names": await self._names(sorted(ids - {""}))})

    async def _names(self, device_ids: list[str]) -> tuple[KeyValue, ...]:
        """Return the names of those that the directory knows; none where it does not answer."""
        if not device_ids:
            return ()
        wanted = Or(tuple(FactIs("id", one.casefold()) for one in device_ids[:_MOST_NAMES]))
        try:
            found = await self._find.call(FindDevicesRequest(query=query_terms(wanted)))
        except ServiceError:
            return ()
        return tuple(KeyValue(key=key, value=name) for key, name in part_names(found.devices).items() if name)

    def requested(self, issuer: str, place: _Part, settings: tuple[Setting, ...], trigger: Trigger, at: float) -> str:
        """Note that *issuer* gave a command to the part *place*; return its id, unique in the home.

        It came at *at*, in seconds since the Unix epoch.
        """
        name = next(self._ids)
        self._keep(JournalNote("requested", at, *place, name, issuer, trigger, settings))
        return name

    def note(
        self,
        kind: EntryKind,
        command: IssuedCommand,
        settings: tuple[Setting, ...] = (),
        text: str = "",
        verdicts: tuple[JournalVerdict, ...] = (),
        results: tuple[CommandResult, ...] = (),
    ) -> None:
        """Note a step of *command*."""
        now, (device, part) = self._clock.now(), command.place
        self._keep(
            JournalNote(
                kind, now, device, part, command.id, command.issuer, NO_TRIGGER, settings, text, verdicts, results
            )
        )

    def judged(self, command: IssuedCommand, verdict: Verdict) -> None:
        """Note the verdict of a policy."""
        facts = tuple(
            JournalFact(name=one.name, value=Value.of(one.value), since=Time.from_seconds(one.since))
            for one in verdict.facts
        )
        noted = JournalVerdict(policy=verdict.policy, allowed=verdict.allowed, reason=verdict.reason, facts=facts)
        self.note("judged", command, verdicts=(noted,))

    def sent(self, command: IssuedCommand, attempt: int) -> None:
        """Note that a command is handed to its gateway, for the *attempt*-th time, from 0 on."""
        self.note("sent", command, text="again" if attempt else "")

    def reverted(self, place: _Part, command_id: str, issuer: str, result: CommandResult) -> None:
        """Note that the confirmed value of a command to the part *place* ended."""
        self._keep(JournalNote("reverted", self._clock.now(), *place, command_id, issuer, results=(result,)))

    def reported(self, command: IssuedCommand, capability: str, value: PlainValue) -> None:
        """Note that the device reported a value of what it was commanded."""
        self.note("reported", command, settings=(Setting.of(capability, value),))

    def decided(self, command_id: str, issuer: str, place: _Part, result: CommandResult) -> None:
        """Note the outcome of a command that *issuer* gave to the part *place*."""
        now = self._clock.now()
        self._keep(JournalNote("outcome", now, *place, command_id, issuer, results=(result,)))

    def changed(self, change: ChangedSetting, command_id: str) -> None:
        """Note *change*, which the raw command *command_id* explains; empty where nothing does."""
        at = change.told_at.to_seconds()
        settings = (Setting(capability=change.capability, value=change.value),)
        kind: EntryKind = "reported" if command_id else "changed"
        self._keep(JournalNote(kind, at, change.device, change.part, command_id, settings=settings))

    def published(
        self, device: str, command: RawCommand, at: float, *, is_sent: bool = True, is_code: bool = False
    ) -> None:
        """Note a raw command for a device, whether it is sent, and whether it is known for a code.

        It came at *at*, in seconds since the Unix epoch.
        """
        name = command.command_id or next(self._ids)
        text = CODE_GIVEN if is_code else command.payload
        if not text.isalpha() or is_for_code(command.address):  # a word such as "on" is no code
            text = public_text(text, command.address)
        text = text[:_LONGEST]
        self._keep(
            JournalNote("published", at, device, "", name, issuer=command.issuer, trigger=command.trigger, text=text)
        )
        if is_sent:
            self._changes.begin_raw(device, name, command.payload, at, at + self._settle)
        else:
            self._keep(JournalNote("would", at, device, "", name, issuer=command.issuer))

    def denied(self, refused: AccessRefused, device: str, count: int) -> None:
        """Note that the door refused *count* requests such as this, for *device* where that is known."""
        from homebot.control.client_commands import POLICY  # noqa: PLC0415 - it has the matching of queries

        facts: dict[str, PlainValue] = {
            "operation": refused.operation,
            "target": refused.target,
            "right": refused.right,
            "address": refused.address,
            "count": float(count),
        }
        verdict = JournalVerdict(
            policy=POLICY,
            allowed=False,
            reason=refused.reason,
            facts=tuple(JournalFact(name=name, value=Value.of(value)) for name, value in facts.items()),
        )
        at = refused.refused_at.to_seconds()
        self._keep(JournalNote("denied", at, device, issuer=refused.issuer, text=refused.wanted, verdicts=(verdict,)))

    def hold_denied(self, request: HoldRequest, policy: str, reason: str) -> None:
        """Note that *request* was refused before anything was commanded for it."""
        self._keep(
            JournalNote(
                "denied",
                self._clock.now(),
                request.device,
                request.part,
                issuer=request.issuer,
                settings=(request.setting,),
                text=request.by,
                verdicts=(JournalVerdict(policy=policy, allowed=False, reason=reason),),
            )
        )

    def lease(self, kind: LeaseStep, place: _Part, held: Setting, issuer: str = "", text: str = "") -> None:
        """Note what became of a lease on the part *place*, a device and one of its parts."""
        self._keep(JournalNote(kind, self._clock.now(), *place, issuer=issuer, settings=(held,), text=text))

    def _keep(self, note: JournalNote) -> None:
        for kept in self._folding.add(note):
            self.store.add(kept)
        if self._entries.subscription_count:
            self._entries.publish(note.entry())
