"""Watches what happens in the house beside the commands: changes that none explains, and raw commands."""

from __future__ import annotations

from functools import partial
from typing import Final, final

import anyio

from homebot.clock import TimeSlice
from homebot.control.journal.command_addresses import CommandAddresses
from homebot.control.journal.explained_changes import WATCHED
from homebot.control.journal.journal import CommandJournal
from homebot.devices import DEVICE_STATES, GatewayNames, RawCommand, StateChange
from homebot.devices.names import DIRECTORY_NODE, gateway_of
from homebot.errors import InvalidNameError
from homebot.graph import Node, QoSProfile, ReliabilityPolicy, Subscription

__all__ = ["HouseWatch"]

_PAUSE: Final = 0.5
"""Seconds in which changes are gathered: to look at them together costs a busy house next to nothing."""

_STATES: Final = QoSProfile(depth=10)
"""Of each stream; a device that changes more often in half a second has the newest noted."""

_RAW: Final = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""The oldest is dropped where they come too fast; a gateway's commands never wait for the journal."""


@final
class HouseWatch:
    """Notes in the journal what no command explains.

    Args:
        node: The node that listens.
        journal: Takes the entries.

    Attributes:
        addresses: The devices that raw commands are for.
    """

    def __init__(self, node: Node, journal: CommandJournal) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._journal = journal
        self._raw: dict[str, Subscription[RawCommand]] = {}
        self.addresses = CommandAddresses(node)

    async def run(self) -> None:
        """Work until cancelled."""
        states = self._node.create_subscription(
            StateChange, DEVICE_STATES, qos_profile=_STATES, from_node=DIRECTORY_NODE
        )
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._watch_gateways)
            while True:
                await states.mailbox.wait()
                await anyio.sleep(_PAUSE)
                work = TimeSlice(self._clock)
                while (change := states.take()) is not None:
                    self._take(change)
                    if work.is_over:
                        await work.pause()

    def _take(self, change: StateChange) -> None:
        if change.live:
            for reading in change.readings:
                if reading.capability in WATCHED:
                    self._journal.changed(change, reading)

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
                RawCommand, names.out, partial(self._take_raw, gateway), _RAW
            )
        except InvalidNameError:
            return  # nobody publishes under such a name

    async def _take_raw(self, gateway: str, command: RawCommand) -> None:
        if command.command_id:
            return  # it passed the control layer, which noted it
        now = self._clock.now()
        device = await self.addresses.device_at(gateway, command.address)
        if device:
            self._journal.published(device, command, now)
