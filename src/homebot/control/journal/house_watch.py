"""Watches what happens in the house beside the commands: changes that none explains, and raw commands."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import TYPE_CHECKING, Final, final

from homebot.control.journal.explained_changes import ExplainedChanges
from homebot.devices import GatewayNames, RawCommand
from homebot.devices.device import ChangedSettings
from homebot.devices.names import DEVICE_SETTINGS, DIRECTORY_NODE, gateway_of
from homebot.errors import InvalidNameError
from homebot.graph import OTHERS, Node, QoSProfile, ReliabilityPolicy, Subscription

if TYPE_CHECKING:
    from homebot.control.journal.command_addresses import CommandAddresses
    from homebot.control.journal.journal import CommandJournal

__all__ = ["HouseWatch"]

_SETTINGS: Final = QoSProfile(depth=100)
"""Messages, each of a few changes of half a second; the oldest is dropped where they come too fast."""

_RAW: Final = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""The oldest is dropped where they come too fast; a gateway's commands never wait for the journal."""


@final
class HouseWatch:
    """Notes in the journal what no command explains.

    Args:
        node: The node that listens.
        changes: Tells which change a command explains.
        journal: Returns what takes the entries, when there is one.
        is_dry_run: Whether gateways send nothing, so that a raw command has no effect.
    """

    def __init__(
        self, node: Node, changes: ExplainedChanges, journal: Callable[[], CommandJournal], *, is_dry_run: bool = False
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._changes = changes
        self._journal = journal
        self._is_dry_run = is_dry_run
        self._raw: dict[str, Subscription[RawCommand]] = {}

    @cached_property
    def addresses(self) -> CommandAddresses:
        """The devices that raw commands are for."""
        from homebot.control.journal.command_addresses import CommandAddresses  # noqa: PLC0415 - few homes have any

        return CommandAddresses(self._node)

    async def run(self) -> None:
        """Work until cancelled."""
        self._node.create_subscription(
            ChangedSettings, DEVICE_SETTINGS, self._take, _SETTINGS, from_node=DIRECTORY_NODE
        )
        await self._watch_gateways()

    def _take(self, changed: ChangedSettings) -> None:
        for change in changed.changes:
            command_id = self._changes.take(change, change.told_at.to_seconds())
            if command_id is not None:
                self._journal().changed(change, command_id)

    async def _watch_gateways(self) -> None:
        """Subscribe to the raw commands for each gateway that comes."""
        async for service in self._node.graph.watch_services():
            names = self._node.graph.get_node_names() if service is None else (service.rpartition("/")[0],)
            for node in names:
                gateway = gateway_of(node)
                if gateway and gateway not in self._raw:
                    self._listen(gateway)

    def _listen(self, gateway: str) -> None:
        try:
            names = GatewayNames(gateway)
            self._raw[gateway] = self._node.create_subscription(
                RawCommand, names.out, partial(self._take_raw, gateway), _RAW, from_node=OTHERS
            )
        except InvalidNameError:
            return  # nobody publishes under such a name

    async def _take_raw(self, gateway: str, command: RawCommand) -> None:
        if command.command_id:
            return  # it has passed a control layer, which noted it
        now = self._clock.now()
        device = await self.addresses.device_at(gateway, command.address)
        if device:
            self._journal().published(device, command, now, is_sent=not self._is_dry_run)
