"""The parts of the control layer, built for the first command, change or question."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final, final

import anyio

from homebot.command_words.command_service import CommandService
from homebot.control.executor import CommandExecutor
from homebot.control.explanations import Explanations
from homebot.control.gateway_feed import GatewayFeed
from homebot.control.journal.denied_requests import DeniedRequests
from homebot.control.journal.journal import CommandJournal
from homebot.control.learnt import LearntPersistence
from homebot.control.lease_service import LeaseService
from homebot.control.leases import Leases
from homebot.control.open_command import SimulatedExecution
from homebot.control.policy_engine import PolicyEngine
from homebot.control.sending import Sending
from homebot.control.settings import ControlSettings
from homebot.control.timelines import Timelines
from homebot.devices.client_rights import CurrentGrants
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.health import HealthResponse
from homebot.graph import Node
from homebot.journal.file_store import FileStore
from homebot.journal.store import JournalStore

_DAY: Final = 86_400.0
_MEGABYTE: Final = 1_000_000

MAX_ENTRIES_IN_MEMORY: Final = 10_000
"""Entries of a journal without a file."""


@final
class ControlLayer:
    """The parts of the control layer, each given the parts that it calls.

    The arguments are those of :class:`homebot.control.Control`.
    """

    def __init__(
        self,
        node: Node,
        feed: GatewayFeed,
        lookup: DeviceLookup,
        settings: ControlSettings | None,
        grants: CurrentGrants,
        *,
        trusts_apps: bool,
        approves_all: bool,
        detected: Iterable[str],
        journal_file: Path | None,
        store: JournalStore | None,
        rehearsal: SimulatedExecution | None,
    ) -> None:
        settings = _with_approvals(settings, approves_all=approves_all)
        store = store or _store(node, settings, journal_file)
        self.journal = CommandJournal(node, store, lookup)
        self.learnt = LearntPersistence(node, store)
        self.timelines = Timelines(node, feed, self.learnt, settings.timeout, settings.settle)
        self.policies = PolicyEngine(
            node,
            lookup,
            settings,
            grants,
            self.journal,
            self.learnt,
            self.timelines,
            trusts_apps=trusts_apps,
            detected=detected,
        )
        leases = Leases(settings.hand_time)
        self.sending = Sending(node, settings, lookup, self.policies, self.journal, leases, self.timelines, rehearsal)
        self.executor = CommandExecutor(node, lookup, self.policies, self.journal, leases, self.timelines, self.sending)
        self.words = CommandService(node, lookup, self.executor)
        self.leases = LeaseService(node, lookup, self.executor, self.journal)
        self.denied = DeniedRequests(node, lookup, self.journal)
        self.explanations = Explanations(
            self.journal.read,
            lookup.device,
            lambda device: self.journal.fights.recent(node.graph.clock.now(), device),
            self.timelines.ineffective_routes,
            feed.began_at,
        )

    def update_policies(self, settings: ControlSettings | None, *, approves_all: bool) -> None:
        """Use the policies of *settings*, None for its defaults; its other keys change nothing."""
        self.policies.update(_with_approvals(settings, approves_all=approves_all))

    async def run(self) -> None:
        """Write the journal, serve the leases and forget old commands until cancelled."""
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self.journal.run)
            tasks.start_soon(self.timelines.run)
            await self.leases.run()

    async def close(self) -> None:
        """Write the last entries of the journal, even when cancelled."""
        self.denied.record_counts()
        await self.journal.close()

    async def health(self) -> HealthResponse:
        """Return the health of the journal, with notes for the owner."""
        notes = await self.policies.approval_notes() + self.sending.witnesses.notes() + self.policies.notes()
        executor = self.executor
        counts = {
            "leases_refused": executor.leases.refused,
            "codes_refused": executor.codes.refused,
            "commands_forgotten": self.timelines.forgotten,
        }
        return self.journal.health(counts | self.sending.witnesses.counts | self.policies.counts, notes)


def _with_approvals(settings: ControlSettings | None, *, approves_all: bool) -> ControlSettings:
    """Return *settings*, by default those of a home, without approvals if *approves_all*."""
    settings = settings or ControlSettings()
    return settings.model_copy(update={"approvals": False}) if approves_all else settings


def _store(node: Node, settings: ControlSettings, journal_file: Path | None) -> JournalStore:
    longest = settings.journal_days * _DAY
    if journal_file is None:
        return JournalStore(MAX_ENTRIES_IN_MEMORY, longest)
    return FileStore(node, journal_file, longest, settings.journal_megabytes * _MEGABYTE, MAX_ENTRIES_IN_MEMORY)
