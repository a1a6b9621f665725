"""Watches what happens in the house beside the commands: changes that none explains, and raw commands."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import TYPE_CHECKING, Final, final

from homebot.control.journal.house_changes import HouseChanges
from homebot.devices import GatewayNames, RawCommand
from homebot.devices.device import ChangedSetting, ChangedSettings
from homebot.devices.names import DEVICE_SETTINGS, DIRECTORY_NODE
from homebot.errors import InvalidNameError
from homebot.graph import OTHERS, Node, QoSProfile, ReliabilityPolicy

if TYPE_CHECKING:
    from homebot.control.journal.command_addresses import CommandAddresses
    from homebot.control.journal.journal import CommandJournal
    from homebot.control.timeline.cause import Attribution

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
        changes: The last values, and the raw commands.
        journal: Returns what takes the entries, when there is one.
        cause_of: Returns the cause of a change; None if no command was ever given to the part.
        is_dry_run: Whether gateways send nothing, so that a raw command has no effect.
    """

    def __init__(
        self,
        node: Node,
        changes: HouseChanges,
        journal: Callable[[], CommandJournal],
        cause_of: Callable[[ChangedSetting], Attribution | None],
        *,
        is_dry_run: bool = False,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._changes = changes
        self._journal = journal
        self._is_dry_run = is_dry_run
        self._cause_of = cause_of

    @cached_property
    def addresses(self) -> CommandAddresses:
        """The devices that raw commands are for."""
        from homebot.control.journal.command_addresses import CommandAddresses  # noqa: PLC0415 - few homes have any

        return CommandAddresses(self._node)

    def follow_settings(self) -> None:
        """Note changes of settings from now on."""
        self._node.create_subscription(
            ChangedSettings, DEVICE_SETTINGS, self._on_settings, _SETTINGS, from_node=DIRECTORY_NODE
        )

    def follow_gateway(self, gateway: str) -> None:
        """Note the raw commands for a gateway from now on."""
        try:
            names = GatewayNames(gateway)
            self._node.create_subscription(
                RawCommand, names.out, partial(self._take_raw, gateway), _RAW, from_node=OTHERS
            )
        except InvalidNameError:
            return  # no node publishes under such a name

    def _on_settings(self, changed: ChangedSettings) -> None:
        for change in changed.changes:
            raw_command = self._changes.record(change, change.told_at.to_seconds())
            if raw_command is None:
                continue
            if not raw_command.id:
                if not _is_in_chain(self._cause_of(change)):
                    self._journal().changed(change, "")
            elif raw_command.says(change.value.plain()) or not _is_in_chain(self._cause_of(change)):
                self._journal().changed(change, raw_command.id)

    async def _take_raw(self, gateway: str, command: RawCommand) -> None:
        if command.command_id:
            return  # it has passed a control layer, which noted it
        now = self._clock.now()
        device = await self.addresses.device_at(gateway, command.address)
        if device:
            self._journal().published(device, command, now, is_sent=not self._is_dry_run)


def _is_in_chain(finding: Attribution | None) -> bool:
    """Return whether the entries of a command have the change, or it is a part of the command's effect."""
    return finding is not None and finding.role is not None
