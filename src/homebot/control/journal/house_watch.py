"""Watch of the house beside commands: unexplained changes, and raw commands of other programs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, final

from homebot.control.device_lookup import DeviceLookup
from homebot.control.journal.house_changes import HouseChanges
from homebot.devices import GatewayNames, RawCommand
from homebot.devices.device import ChangedSetting, ChangedSettings
from homebot.devices.names import DEVICE_SETTINGS, DIRECTORY_NODE
from homebot.errors import InvalidNameError
from homebot.graph import OTHERS, Node, QoSProfile, ReliabilityPolicy

if TYPE_CHECKING:
    from homebot.control.journal.journal import CommandJournal
    from homebot.control.timeline.cause import Attribution

__all__ = ["HouseWatch"]

_SETTINGS: Final = QoSProfile(depth=100)
"""Each message has the changes of half a second; the oldest is dropped in a flood."""

_RAW: Final = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""The oldest is dropped in a flood; a gateway's commands never wait for the journal."""


@final
class HouseWatch:
    """Records unexplained changes and raw commands in the journal.

    Args:
        node: The subscribing node.
        lookup: Looks the devices up.
        journal: Returns the journal, which is built for the first entry.
        cause_of: Returns the cause of a change; None if no command was ever given to the part.
        is_dry_run: Whether gateways send nothing, so that a raw command has no effect.

    Attributes:
        changes: The last values, and the raw commands.
    """

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        journal: Callable[[], CommandJournal],
        cause_of: Callable[[ChangedSetting], Attribution | None],
        *,
        is_dry_run: bool = False,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._journal = journal
        self._is_dry_run = is_dry_run
        self._cause_of = cause_of
        self.changes = HouseChanges()

    def follow_settings(self) -> None:
        """Record changes of settings from now on."""
        self._node.create_subscription(
            ChangedSettings, DEVICE_SETTINGS, self._on_settings, _SETTINGS, from_node=DIRECTORY_NODE
        )

    def follow_gateway(self, gateway: str) -> None:
        """Record the raw commands to a gateway from now on."""
        try:
            out = GatewayNames(gateway).out
            self._node.create_subscription(RawCommand, out, partial(self._on_raw, gateway), _RAW, from_node=OTHERS)
        except InvalidNameError:
            return  # no node publishes under such a name

    def _on_settings(self, changed: ChangedSettings) -> None:
        for change in changed.changes:
            raw = self.changes.record(change, change.told_at.to_seconds())
            if raw is None:
                continue
            attribution = self._cause_of(change)
            if raw.id and raw.means(change.value.plain()):
                self._journal().changed(change, raw.id, "command")
            elif attribution is None or attribution.role is None:  # else the entries of a command have it
                cause = "person" if attribution is None else attribution.cause.value
                self._journal().changed(change, raw.id, "command" if raw.id else cause)

    async def _on_raw(self, gateway: str, command: RawCommand) -> None:
        if command.command_id:
            return  # the control layer sent it, and recorded it
        now = self._clock.now()
        device = await self._lookup.device_at(gateway, command.address)
        if device:
            self._journal().published(device, command, now, is_sent=not self._is_dry_run)
