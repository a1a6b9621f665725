"""The node of the control layer: takes the commands of applications and of other programs.

What carries them out is loaded with the first one: most homes start without.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, final

import anyio
from anyio.abc import TaskStatus

from homebot.control.journal import CommandJournal
from homebot.control.journal.denied_requests import DeniedRequests
from homebot.control.journal.house_watch import HouseWatch
from homebot.control.journal.memory_store import MemoryStore
from homebot.control.journal.store import JournalStore
from homebot.control.settings import ControlSettings
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import (
    COMMAND_DEVICES,
    END_LEASES,
    GET_LEASES,
    GET_UNAPPROVED,
    HOLD_PART,
    PERFORM_COMMAND,
    RELEASE_LEASE,
    RENEW_LEASE,
    SEND_TEXT,
)
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.control.approvals import Approvals
    from homebot.control.command_service import CommandService
    from homebot.control.executor import CommandExecutor
    from homebot.control.judge import Judge
    from homebot.control.lease_keeper import LeaseKeeper
    from homebot.control.rehearsal import Rehearsal
    from homebot.control.text_commands import TextCommands
    from homebot.devices.approval_messages import UnapprovedRequest, UnapprovedResponse
    from homebot.devices.command_messages import (
        CommandDevicesRequest,
        CommandDevicesResponse,
        CommandRequest,
        CommandResult,
    )
    from homebot.devices.lease_messages import (
        EndLeasesRequest,
        GetLeasesRequest,
        HolderRequest,
        HoldRequest,
        LeaseResponse,
        LeasesResponse,
    )
    from homebot.devices.text_messages import SendTextRequest, SendTextResponse

__all__ = ["Control"]

_DAY: Final = 86_400.0
_MEGABYTE: Final = 1_000_000

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
        journal_file: Where the journal is kept over a restart; None for nowhere.
        rehearsal: Answers commands in place of the devices; None where they are sent.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings | None = None,
        grants: Mapping[str, tuple[str, ...]] = MappingProxyType({}),
        *,
        trusts_apps: bool = False,
        journal_file: Path | None = None,
        rehearsal: Rehearsal | None = None,
    ) -> None:
        self._node = node
        self._settings = settings or ControlSettings()
        self._journal = CommandJournal(node, self._store(journal_file), self._settings.settle)
        self._rehearsal = rehearsal
        self._house_watch = HouseWatch(node, self._journal)
        self._denied = DeniedRequests(node, self._journal, self._house_watch.addresses)
        self._grants = grants
        self._trusts_apps = trusts_apps
        if self._settings.needs_house:
            _ = self._judge  # it follows the house from the start
        self._executor: CommandExecutor | None = None
        self._words: CommandService | None = None
        self._keeper: LeaseKeeper | None = None
        self._texts: TextCommands | None = None
        self._begun = anyio.Event()

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Work until cancelled."""
        self.register()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._journal.run)
            tasks.start_soon(self._house_watch.run)
            task_status.started()
            await self._begun.wait()
            tasks.start_soon(self._execution().run)
            await self._leasing().run()

    def register(self) -> None:
        """Offer the services; what they begin is carried out while it serves."""
        from homebot.devices import lease_messages as leases  # noqa: PLC0415 - likewise
        from homebot.devices.approval_messages import GetUnapproved  # noqa: PLC0415 - see above
        from homebot.devices.command_messages import CommandDevices, PerformCommand  # noqa: PLC0415 - see above
        from homebot.devices.text_messages import SendText  # noqa: PLC0415 - likewise

        self._node.create_service(PerformCommand, PERFORM_COMMAND, self.perform, concurrent=True)
        self._node.create_service(SendText, SEND_TEXT, self.send_text, concurrent=True)
        self._node.create_service(CommandDevices, COMMAND_DEVICES, self.command_devices, concurrent=True)
        self._node.create_service(leases.HoldPart, HOLD_PART, self.hold, concurrent=True)
        self._node.create_service(leases.RenewLease, RENEW_LEASE, self.renew)
        self._node.create_service(leases.ReleaseLease, RELEASE_LEASE, self.release)
        self._node.create_service(leases.GetLeases, GET_LEASES, self.held_parts)
        self._node.create_service(leases.EndLeases, END_LEASES, self.end_leases)
        self._node.create_service(GetUnapproved, GET_UNAPPROVED, self.unapproved)
        self._node.create_service(GetHealth, "~/health", self.health)

    async def perform(self, request: CommandRequest) -> CommandResult:
        """Carry out a command to one part, and return what became of it."""
        return await self._execution().perform(request)

    async def send_text(self, request: SendTextRequest) -> SendTextResponse:
        """Send a raw text to a device; return when its gateway has queued it."""
        if self._texts is None:
            from homebot.control.text_commands import TextCommands  # noqa: PLC0415 - few apps send texts

            self._texts = TextCommands(self._node, self._execution(), self._judge, self._journal)
        return await self._texts.send(request)

    async def command_devices(self, request: CommandDevicesRequest) -> CommandDevicesResponse:
        """Carry out a command in words, to one device or to all that fit a query."""
        if self._words is None:
            from homebot.control.command_service import CommandService  # noqa: PLC0415 - it has the parser of queries

            self._words = CommandService(self._node, self.perform)
        return await self._words.serve(request)

    async def hold(self, request: HoldRequest) -> LeaseResponse:
        """Command a value of a part and hold it for somebody."""
        return await self._leasing().hold(request)

    def renew(self, request: HolderRequest) -> LeaseResponse:
        """Let a holder hold on."""
        return self._leasing().renew(request)

    def release(self, request: HolderRequest) -> LeaseResponse:
        """Let a holder hold no more."""
        return self._leasing().release(request)

    def held_parts(self, request: GetLeasesRequest) -> LeasesResponse:
        """Return the parts that are held."""
        return self._leasing().held_parts(request)

    def end_leases(self, request: EndLeasesRequest) -> LeasesResponse:
        """Let nobody hold a device any more."""
        return self._leasing().end(request)

    async def unapproved(self, request: UnapprovedRequest) -> UnapprovedResponse:
        """Return the devices that wait for the owner's approval."""
        return await self._approvals.unapproved(request)

    async def health(self, _: HealthRequest) -> HealthResponse:
        """Return the health of the journal, with a note on the devices that wait for the owner's approval."""
        return self._journal.health().with_checked(notes=await self._approvals.notes())

    @cached_property
    def _judge(self) -> Judge:
        from homebot.control.judge import Judge  # noqa: PLC0415 - see above

        return Judge(self._node, self._settings, self._grants, self._journal, trusts_apps=self._trusts_apps)

    @cached_property
    def _approvals(self) -> Approvals:
        from homebot.control.approvals import Approvals  # noqa: PLC0415 - for people who ask

        return Approvals(self._node, is_needed=self._settings.approvals)

    def _store(self, file: Path | None) -> JournalStore:
        longest = self._settings.journal_days * _DAY
        in_memory = MemoryStore(MOST_IN_MEMORY, longest)
        if file is None:
            return in_memory
        from homebot.control.journal.file_store import FileStore  # noqa: PLC0415 - for homes that are remembered

        return FileStore(self._node, file, longest, self._settings.journal_megabytes * _MEGABYTE, in_memory)

    def _execution(self) -> CommandExecutor:
        if self._executor is None:
            from homebot.control.executor import CommandExecutor  # noqa: PLC0415 - see above
            from homebot.control.leases import Leases  # noqa: PLC0415 - likewise

            leases = Leases(self._settings.hand_time)
            self._journal.add_counter("leases_refused", lambda: leases.refused)
            self._executor = CommandExecutor(
                self._node, self._settings, self._judge, self._journal, leases, self._rehearsal
            )
            self._begun.set()
        return self._executor

    def _leasing(self) -> LeaseKeeper:
        if self._keeper is None:
            from homebot.control.lease_keeper import LeaseKeeper  # noqa: PLC0415 - likewise

            self._keeper = LeaseKeeper(self._node, self._execution(), self._journal)
        return self._keeper
