"""The node of the control layer: takes the commands of applications and of other programs.

What carries them out is loaded with the first one, in a home that keeps no journal yet: most tests and first starts do
without.
"""

from __future__ import annotations

from collections.abc import Awaitable, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, final

import anyio
from anyio.abc import TaskStatus

from homebot.control.journal.house_changes import HouseChanges
from homebot.control.journal.house_watch import HouseWatch
from homebot.control.reports import GatewayFeed
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import (
    ACCESS_REFUSALS,
    CLIENTS_LEFT,
    COMMAND_DEVICES,
    END_LEASES,
    GET_LEASES,
    GET_UNAPPROVED,
    HOLD_PART,
    PERFORM_COMMAND,
    READ_JOURNAL,
    RELEASE_LEASE,
    RENEW_LEASE,
    SEND_TEXT,
    TRUST_DEVICE,
)
from homebot.graph import Node, QoSProfile

if TYPE_CHECKING:
    from homebot.control.approvals import Approvals
    from homebot.control.command_service import CommandService
    from homebot.control.executor import CommandExecutor
    from homebot.control.journal import CommandJournal
    from homebot.control.journal.denied_requests import DeniedRequests
    from homebot.control.journal.store import JournalStore
    from homebot.control.judge import Judge
    from homebot.control.learnt_persistence import LearntPersistence
    from homebot.control.lease_keeper import LeaseKeeper
    from homebot.control.rehearsal import Rehearsal
    from homebot.control.settings import ControlSettings
    from homebot.control.text_commands import TextCommands
    from homebot.control.timeline.cause import Attribution
    from homebot.control.timelines import Timelines
    from homebot.devices.access_messages import AccessRefused, ClientLeft
    from homebot.devices.approval_messages import (
        TrustDeviceRequest,
        TrustDeviceResponse,
        UnapprovedRequest,
        UnapprovedResponse,
    )
    from homebot.devices.command_messages import (
        CommandDevicesRequest,
        CommandDevicesResponse,
        CommandRequest,
        CommandResult,
        SendTextRequest,
        SendTextResponse,
    )
    from homebot.devices.device import ChangedSetting
    from homebot.devices.journal_messages import ReadJournalRequest, ReadJournalResponse
    from homebot.devices.lease_messages import (
        EndLeasesRequest,
        GetLeasesRequest,
        HolderRequest,
        HoldRequest,
        LeaseResponse,
        LeasesResponse,
    )
    from homebot.devices.misspelt_names import ConfiguredNames

__all__ = ["Control"]

_DAY: Final = 86_400.0
_MEGABYTE: Final = 1_000_000
_REFUSALS: Final = 1000

MOST_IN_MEMORY: Final = 10_000
"""Entries of the journal where there is no file."""


@final
class Control:
    """The one way of commands from applications to devices.

    Args:
        node: The node that it is on the graph.
        settings: How long it waits, and the policies.
        grants: The scope of each node that may not command everything, by its full name; see `CommandRequest`.
        trusts_apps: Whether nodes without a scope may command what always asks, as in a simulated house.
        approves_all: Whether no device needs an approval, whatever the settings say, as there.
        journal_file: Where the journal, and what commands teach, is kept over a restart; None for nowhere.
        store: Keeps them in place of a file.
        rehearsal: Answers commands in place of the devices; None where they are sent.
        detected: Motion sensors that detected somebody before; see :meth:`detected`.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings | None = None,
        grants: Mapping[str, tuple[str, ...]] = MappingProxyType({}),
        *,
        trusts_apps: bool = False,
        approves_all: bool = False,
        journal_file: Path | None = None,
        store: JournalStore | None = None,
        rehearsal: Rehearsal | None = None,
        detected: Iterable[str] = (),
    ) -> None:
        self._node = node
        self._given_settings = settings
        self._approves_all = approves_all
        self._journal_file = journal_file
        self._given_store = store
        self._changes = HouseChanges()
        self._rehearsal = rehearsal
        self._detected = detected
        is_dry_run = rehearsal is not None and rehearsal.is_live
        self._feed = GatewayFeed(node)
        self._house_watch = HouseWatch(
            node, self._changes, lambda: self._journal, self._cause_of_change, is_dry_run=is_dry_run
        )
        self._feed.on_gateway = self._house_watch.follow_gateway
        self._grants = grants
        self._trusts_apps = trusts_apps
        self._begun = anyio.Event()
        self._has_timelines = False
        self._noted = anyio.Event()
        if settings is not None and settings.needs_house:
            _ = self._judge  # it follows the house from the start

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Work until cancelled."""
        self.register()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._run_journal)
            self._house_watch.follow_settings()
            tasks.start_soon(self._feed.run)
            if self._names is not None:
                tasks.start_soon(self._names.run)
            task_status.started()
            if self._journal_file is not None and await anyio.Path(self._journal_file).exists():
                _ = self._executor  # what was learnt is read before the first command
            await self._begun.wait()
            tasks.start_soon(self._executor.run)
            await self._leasing.run()

    def register(self) -> None:
        """Offer the services; what they begin is carried out while it serves."""
        from homebot.devices import lease_messages as leases  # noqa: PLC0415 - likewise
        from homebot.devices.access_messages import AccessRefused, ClientLeft  # noqa: PLC0415 - likewise
        from homebot.devices.approval_messages import GetUnapproved, TrustDevice  # noqa: PLC0415 - see above
        from homebot.devices.command_messages import (  # noqa: PLC0415 - see above
            CommandDevices,
            PerformCommand,
            SendText,
        )
        from homebot.devices.journal_messages import ReadJournal  # noqa: PLC0415 - likewise

        self._node.create_service(PerformCommand, PERFORM_COMMAND, self.perform, concurrent=True)
        self._node.create_service(SendText, SEND_TEXT, self.send_text, concurrent=True)
        self._node.create_service(CommandDevices, COMMAND_DEVICES, self.command_devices, concurrent=True)
        self._node.create_service(leases.HoldPart, HOLD_PART, self.hold, concurrent=True)
        self._node.create_service(leases.RenewLease, RENEW_LEASE, self.renew)
        self._node.create_service(leases.ReleaseLease, RELEASE_LEASE, self.release)
        self._node.create_service(leases.GetLeases, GET_LEASES, self.held_parts)
        self._node.create_service(leases.EndLeases, END_LEASES, self.end_leases)
        self._node.create_service(GetUnapproved, GET_UNAPPROVED, self.unapproved)
        self._node.create_service(TrustDevice, TRUST_DEVICE, self.trust)
        self._node.create_service(GetHealth, "~/health", self.health)
        self._node.create_service(ReadJournal, READ_JOURNAL, self.read_journal, concurrent=True)
        self._node.create_subscription(AccessRefused, ACCESS_REFUSALS, self._take_refusal, QoSProfile(depth=_REFUSALS))
        self._node.create_subscription(ClientLeft, CLIENTS_LEFT, self._on_client_left, QoSProfile(depth=_REFUSALS))

    def perform(self, request: CommandRequest) -> Awaitable[CommandResult]:
        """Carry out a command to one part, and return what became of it."""
        return self._executor.perform(request)

    def send_text(self, request: SendTextRequest) -> Awaitable[SendTextResponse]:
        """Send a raw text to a device; return when its gateway has queued it."""
        return self._texts.send(request)

    async def command_devices(self, request: CommandDevicesRequest) -> CommandDevicesResponse:
        """Carry out a command in words, to one device or to all that fit a query."""
        return await self._words.serve(request)

    async def detected(self) -> tuple[str, ...]:
        """Return the motion sensors that have ever detected somebody: the presence guard believes only them."""
        return await self._judge.detected() if self._settings.needs_house else ()

    async def hold(self, request: HoldRequest) -> LeaseResponse:
        """Command a value of a part and hold it for somebody."""
        return await self._leasing.hold(request)

    def renew(self, request: HolderRequest) -> LeaseResponse:
        """Let a holder hold on."""
        return self._leasing.renew(request)

    def release(self, request: HolderRequest) -> LeaseResponse:
        """Let a holder hold no more."""
        return self._leasing.release(request)

    def held_parts(self, request: GetLeasesRequest) -> LeasesResponse:
        """Return the parts that are held."""
        return self._leasing.held_parts(request)

    def end_leases(self, request: EndLeasesRequest) -> LeasesResponse:
        """Let nobody hold a device any more."""
        return self._leasing.end(request)

    async def unapproved(self, request: UnapprovedRequest) -> UnapprovedResponse:
        """Return the devices that wait for the owner's approval."""
        return await self._approvals.unapproved(request)

    def trust(self, request: TrustDeviceRequest) -> TrustDeviceResponse:
        """Forget that a witness contradicted a device."""
        from homebot.devices.approval_messages import TrustDeviceResponse  # noqa: PLC0415 - see above

        return TrustDeviceResponse(witnesses=self._executor.witnesses.trust(request.device))

    async def health(self, _: HealthRequest) -> HealthResponse:
        """Return the health of the journal, with notes on what waits for the owner."""
        notes = await self._approvals.notes()
        if self._begun.is_set():
            notes += self._executor.witnesses.notes()
        if self._settings.presence_guard is not None:
            notes += self._judge.notes()
        health = self._journal.health().model_copy(update={"notes": notes})
        problems = () if self._names is None else await self._names.problems()
        return health.model_copy(update={"troubles": health.troubles + problems}) if problems else health

    async def read_journal(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return entries of the journal."""
        return await self._journal.read(request)

    async def _take_refusal(self, refused: AccessRefused) -> None:
        await self._denied.take(refused)

    def _on_client_left(self, left: ClientLeft) -> None:
        if self._begun.is_set():
            self._leasing.on_client_left(left.issuer)

    async def _run_journal(self) -> None:
        await self._noted.wait()
        await self._journal.run()

    @cached_property
    def _settings(self) -> ControlSettings:
        from homebot.control.settings import ControlSettings  # noqa: PLC0415 - few homes have any

        settings = self._given_settings or ControlSettings()
        return settings.model_copy(update={"approvals": False}) if self._approves_all else settings

    @cached_property
    def _names(self) -> ConfiguredNames | None:
        """The rooms and devices that the settings name; None where they name none."""
        settings = self._given_settings
        if settings is None or not settings.names_devices:
            return None
        from homebot.control.named_devices import named_devices  # noqa: PLC0415 - few homes name any

        return named_devices(self._node, settings)

    @cached_property
    def _journal(self) -> CommandJournal:
        from homebot.control.journal.journal import CommandJournal  # noqa: PLC0415 - see above

        self._noted.set()
        return CommandJournal(self._node, self._store, self._changes, self._settings.settle)

    @cached_property
    def _denied(self) -> DeniedRequests:
        from homebot.control.journal.denied_requests import DeniedRequests  # noqa: PLC0415 - for doors that refuse

        return DeniedRequests(self._node, self._journal, self._house_watch.addresses)

    @cached_property
    def _judge(self) -> Judge:
        from homebot.control.judge import Judge  # noqa: PLC0415 - see above

        return Judge(
            self._node,
            self._settings,
            self._grants,
            self._journal,
            self._timelines,
            trusts_apps=self._trusts_apps,
            detected=self._detected,
        )

    @cached_property
    def _learnt(self) -> LearntPersistence:
        from homebot.control.learnt_persistence import LearntPersistence  # noqa: PLC0415 - see above

        return LearntPersistence(self._node, self._journal.store)

    @cached_property
    def _timelines(self) -> Timelines:
        from homebot.control.profiles import PROFILE, Profiles  # noqa: PLC0415 - see above
        from homebot.control.timelines import Timelines  # noqa: PLC0415 - see above

        profiles = Profiles(self._learnt.keeper(PROFILE))
        self._learnt.add(PROFILE, profiles)
        self._has_timelines = True
        return Timelines(self._node, self._feed, profiles, self._settings.timeout, self._settings.settle)

    def _cause_of_change(self, change: ChangedSetting) -> Attribution | None:
        """Return the cause of a change; None if no command was ever given to the part."""
        if not self._has_timelines:
            return None
        stamp = change.told_at.to_seconds()
        return self._timelines.cause((change.device, change.part), change.capability, change.value.plain(), stamp)

    @cached_property
    def _approvals(self) -> Approvals:
        from homebot.control.approvals import Approvals  # noqa: PLC0415 - for people who ask

        return Approvals(self._node, is_needed=self._settings.approvals)

    @property
    def _store(self) -> JournalStore:
        if self._given_store is not None:
            return self._given_store
        from homebot.control.journal.memory_store import MemoryStore  # noqa: PLC0415 - likewise

        longest = self._settings.journal_days * _DAY
        in_memory = MemoryStore(MOST_IN_MEMORY, longest)
        if self._journal_file is None:
            return in_memory
        from homebot.control.journal.file_store import FileStore  # noqa: PLC0415 - for homes that are remembered

        return FileStore(
            self._node, self._journal_file, longest, self._settings.journal_megabytes * _MEGABYTE, in_memory
        )

    @cached_property
    def _executor(self) -> CommandExecutor:
        from homebot.control.executor import CommandExecutor  # noqa: PLC0415 - see above
        from homebot.control.leases import Leases  # noqa: PLC0415 - likewise

        leases = Leases(self._settings.hand_time)
        self._journal.add_counter("leases_refused", lambda: leases.refused)
        executor = CommandExecutor(
            self._node,
            self._settings,
            self._judge,
            self._journal,
            leases,
            self._timelines,
            self._feed,
            self._learnt,
            self._rehearsal,
        )
        self._begun.set()
        return executor

    @cached_property
    def _texts(self) -> TextCommands:
        from homebot.control.text_commands import TextCommands  # noqa: PLC0415 - few apps send texts

        return TextCommands(self._node, self._executor, self._judge, self._journal)

    @cached_property
    def _words(self) -> CommandService:
        from homebot.control.command_service import CommandService  # noqa: PLC0415 - it has the parser of queries

        return CommandService(self._node, self.perform)

    @cached_property
    def _leasing(self) -> LeaseKeeper:
        from homebot.control.lease_keeper import LeaseKeeper  # noqa: PLC0415 - likewise

        return LeaseKeeper(self._node, self._executor, self._journal)
