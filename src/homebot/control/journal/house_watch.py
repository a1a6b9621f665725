"""Watch of unexplained changes, and of raw commands of other programs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, final

from homebot.devices import GatewayNames, RawCommand
from homebot.devices.capabilities import SETTABLE
from homebot.devices.device import ChangedSetting, ChangedSettings
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import DEVICE_SETTINGS, DIRECTORY_NODE
from homebot.graph import OTHERS, Node, QoSProfile, ReliabilityPolicy

if TYPE_CHECKING:
    from homebot.control.control_layer import ControlLayer

_SETTINGS: Final = QoSProfile(depth=100)
"""Each message has the changes of half a second; in a flood the oldest is dropped."""

_RAW: Final = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""In a flood the oldest is dropped; a gateway's commands never wait for the journal."""

_CALM: Final = 10.0
"""Seconds in which further numbers of one setting are not recorded: from a dial that is turned, or a moving blind."""


def _is_change(change: ChangedSetting) -> bool:
    """Return whether a setting changed from one known value to another, and is no dial that is still turned."""
    value, before = change.value.plain(), change.before.plain()
    if change.capability not in SETTABLE or None in (value, before) or value == before:
        return False
    is_soon = change.told_at.to_seconds() - change.before_since.to_seconds() < _CALM
    return not (isinstance(value, float) and value and before and is_soon)


@final
class HouseWatch:
    """Records unexplained changes and raw commands in the journal.

    The first value of each setting is not a change.

    Args:
        layer: Returns the control layer, which is built for the first entry.
        is_dry_run: Whether gateways send nothing, so raw commands have no effect.
    """

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        layer: Callable[[], ControlLayer],
        *,
        is_dry_run: bool,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._layer = layer
        self._is_dry_run = is_dry_run

    def follow_settings(self) -> None:
        """Record changes of settings from now on."""
        self._node.create_subscription(
            ChangedSettings, DEVICE_SETTINGS, self._on_settings, _SETTINGS, from_node=DIRECTORY_NODE
        )

    def follow_gateway(self, gateway: str) -> None:
        """Record the raw commands to a gateway from now on."""
        out = GatewayNames(gateway).out
        self._node.create_subscription(RawCommand, out, partial(self._on_raw, gateway), _RAW, from_node=OTHERS)

    async def _on_settings(self, changed: ChangedSettings) -> None:
        for change in changed.changes:
            if not _is_change(change):
                continue
            layer, place = self._layer(), (change.device, change.part)
            if not layer.timelines.has(place) and (device := await self._lookup.known(change.device)) is not None:
                layer.timelines.begin(device, change)
            layer.executor.reports.on_change(change)

    async def _on_raw(self, gateway: str, command: RawCommand) -> None:
        # Control's own commands do not come here; an id that another program gives would let it hide the command.
        now, command = self._clock.now(), command.model_copy(update={"command_id": ""})
        device_id = await self._lookup.device_at(gateway, command.address)
        if not device_id:
            return
        layer = self._layer()
        name = layer.journal.published(device_id, command, now, is_sent=not self._is_dry_run)
        if self._is_dry_run or (device := await self._lookup.known(device_id)) is None:
            return
        await layer.executor.record_raw(name, device, gateway, command)
