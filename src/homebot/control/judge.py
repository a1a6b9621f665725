"""The judge of commands: asks the policies, with the facts that they need of the house."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import tzinfo
from functools import cached_property
from typing import TYPE_CHECKING, final

from homebot.control.command import IssuedCommand
from homebot.control.journal import CommandJournal
from homebot.control.policies.settings import PolicySettings
from homebot.devices import DEVICE_STATES, FIND_DEVICES, FindDevices, Follow, StateChange
from homebot.devices.client_rights import is_client
from homebot.devices.names import DIRECTORY_NODE
from homebot.devices.outcomes import Refused
from homebot.devices.query import Query, query_terms
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.control.policies import House, Policies
    from homebot.control.policies.recent_commands import RecentCommands
    from homebot.devices.client_rights import ClientRights

__all__ = ["Judge"]


@final
class Judge:
    """Asks the policies about each command.

    The devices that policies need are followed; where none needs any, nothing is.

    Args:
        node: The node that follows them.
        settings: The policies.
        grants: The scope of each node that may not command everything, by its full name.
        journal: Notes the verdicts of policies that a command concerns.
        trusts_apps: Whether nodes without a scope may command what always asks.
    """

    def __init__(
        self,
        node: Node,
        settings: PolicySettings,
        grants: Mapping[str, tuple[str, ...]],
        journal: CommandJournal,
        *,
        trusts_apps: bool,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settings = settings
        self._grants = grants
        self._journal = journal
        self._trusts_apps = trusts_apps
        if settings.needs_house:
            node.create_task(self._follow)

    def refusal(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of *command*; None if it may be sent now."""
        from homebot.control.policies.facts import Facts  # noqa: PLC0415 - as for the policies

        facts = Facts(self._clock.now(), self._clock.monotonic(), self._zone, self._house, self._recent)
        verdicts = self._policies.judge(command, facts)
        for verdict in verdicts:
            if verdict.reason or not verdict.allowed:
                self._journal.judged(command, verdict)
        if not verdicts or verdicts[-1].allowed:
            return None
        return Refused(verdicts[-1].policy, verdicts[-1].reason, command_id=command.id)

    def rights(self, issuer: str) -> ClientRights:
        """Return the rights of *issuer*, by the configuration; those of a client of the door were checked before."""
        from homebot.devices.client_rights import ALL_RIGHTS, LOCAL_RIGHTS, read_scope  # noqa: PLC0415 - likewise

        if is_client(issuer):
            return ALL_RIGHTS
        if scope := self._grants.get(issuer):
            return read_scope(scope)
        return ALL_RIGHTS if self._trusts_apps or not self._settings.always_ask else LOCAL_RIGHTS

    def note_sent(self, command: IssuedCommand) -> None:
        """Note that *command* was sent."""
        self._recent.note(command, self._clock.monotonic())

    @cached_property
    def _policies(self) -> Policies:
        from homebot.control.policies.policies import Policies  # noqa: PLC0415 - a start gives no commands

        return Policies(self._settings)

    @cached_property
    def _house(self) -> House:
        from homebot.control.policies.house import House  # noqa: PLC0415 - likewise

        return House()

    @cached_property
    def _recent(self) -> RecentCommands:
        from homebot.control.policies.recent_commands import RecentCommands  # noqa: PLC0415 - likewise

        return RecentCommands()

    @cached_property
    def _zone(self) -> tzinfo | None:
        if not self._settings.time_zone:
            return None
        from zoneinfo import ZoneInfo  # noqa: PLC0415 - only where the configuration has one

        return ZoneInfo(self._settings.time_zone)

    async def _follow(self) -> None:
        needs = self._policies.needs
        self._node.create_subscription(StateChange, DEVICE_STATES, self._house.take, 1, from_node=DIRECTORY_NODE)
        await self._read(needs)
        async for change in Follow(self._node, query=needs):
            if change.kind == "removed":
                self._house.remove(change.device.id)
            else:
                self._house.put(change.device, change.sequence)

    async def _read(self, needs: Query) -> None:
        """Read the devices that are known already; those to come are followed."""
        find = self._node.create_client(FindDevices, FIND_DEVICES)
        await find.wait_for_service()
        try:
            found = await find.call(FindDevicesRequest(query=query_terms(needs)))
        except ServiceError:
            return
        for device in found.devices:
            self._house.put(device, found.sequence)
        self._house.is_known = True
