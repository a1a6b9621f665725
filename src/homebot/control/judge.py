"""The judge of commands: asks the policies, with the facts that they need of the house."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, final

from homebot.control.command import IssuedCommand
from homebot.control.journal import CommandJournal
from homebot.control.policies.settings import PolicySettings
from homebot.devices import DEVICE_STATES, FIND_DEVICES, FindDevices, Follow, StateChange
from homebot.devices.names import DIRECTORY_NODE
from homebot.devices.outcomes import Refused
from homebot.devices.query import Query, query_terms
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.control.policies import House, Policies

__all__ = ["Judge"]


@final
class Judge:
    """Asks the policies about each command.

    The devices that policies need are followed; where none needs any, nothing is.

    Args:
        node: The node that follows them.
        settings: The policies.
        journal: Notes the verdicts of policies that a command concerns.
    """

    def __init__(self, node: Node, settings: PolicySettings, journal: CommandJournal) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settings = settings
        self._journal = journal
        if settings.needs_house:
            node.create_task(self._follow)

    def refusal(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of *command*; None if it may be sent now."""
        from homebot.control.policies.facts import Facts  # noqa: PLC0415 - as for the policies

        facts = Facts(self._clock.now(), None, self._house)
        verdicts = self._policies.judge(command, facts)
        for verdict in verdicts:
            if verdict.reason or not verdict.allowed:
                self._journal.judged(command, verdict)
        if not verdicts or verdicts[-1].allowed:
            return None
        return Refused(verdicts[-1].policy, verdicts[-1].reason, command_id=command.id)

    @cached_property
    def _policies(self) -> Policies:
        from homebot.control.policies.policies import Policies  # noqa: PLC0415 - a start gives no commands

        return Policies(self._settings)

    @cached_property
    def _house(self) -> House:
        from homebot.control.policies.house import House  # noqa: PLC0415 - likewise

        return House()

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
