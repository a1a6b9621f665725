"""The reference gateway: devices that exist in this process alone. No socket, so it runs in virtual time as well.

It shows what a gateway has to do: keep one :class:`PublishedDevices`, put and remove devices, report what they say,
carry out commands, and publish how its link is.
"""

from __future__ import annotations

from collections import deque
from typing import Annotated, ClassVar, Literal

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict, Field

from homebot.devices import RawCommand
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError
from homebot.gateways.announced.published_devices import MAX_DEVICES, PublishedDevices
from homebot.gateways.base import Gateway
from homebot.gateways.context import GatewayContext
from homebot.graph import Node

__all__ = ["MemoryGateway", "MemoryGatewaySettings"]

KEPT = 1000
"""Commands that are remembered; the oldest goes."""


class MemoryGatewaySettings(BaseModel):
    """The table ``[gateways.NAME]`` of a gateway in memory.

    Attributes:
        act: Whether commands are carried out; false observes only.
        delivery: As of an MQTT gateway: one ``inbox`` for each node that listens, or a ``mirror`` of each device.
        stale_after: Seconds of silence after which a device counts as stale.
        max_devices: Devices that may be known at once.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    act: bool = True
    delivery: Literal["inbox", "mirror"] = "inbox"
    stale_after: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 3600.0
    max_devices: Annotated[int, Field(ge=1)] = MAX_DEVICES


class MemoryGateway(Gateway):
    """A gateway whose devices do what they are told, and report it.

    Args:
        node: Its node.
        settings: Its table.
        context: What its host gives it; it needs nothing.

    Attributes:
        devices: Its devices.
        commands: The commands that it carried out, oldest first; at most 1,000.
        raw_commands: Likewise of raw commands.
    """

    Settings: ClassVar[type[BaseModel]] = MemoryGatewaySettings

    def __init__(
        self, node: Node, settings: MemoryGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        settings = settings or MemoryGatewaySettings()
        super().__init__(node, settings, context)
        self.acts = settings.act
        self.commands: deque[Command] = deque(maxlen=KEPT)
        self.raw_commands: deque[RawCommand] = deque(maxlen=KEPT)
        self.devices = PublishedDevices(
            self,
            self._perform,
            send_raw=self._send_raw,
            find_source=self.find_source,
            stale_after=settings.stale_after,
            inboxes=settings.delivery == "inbox",
            max_devices=settings.max_devices,
        )
        self._unavailable = ""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be there until cancelled."""
        self.publish_state("active")
        task_status.started()
        await anyio.sleep_forever()

    def set_available(self) -> None:
        """Let the devices be reached again."""
        self._unavailable = ""
        self.publish_state("active")

    def set_unavailable(self, reason: str) -> None:
        """Let no device be reached, for a *reason* in words; all are kept."""
        self._unavailable = reason
        self.publish_state("unavailable", reason)

    async def _perform(self, command: Command) -> None:
        self._check_link()
        self.commands.append(command)
        await self.devices.report(command.key, {command.capability: command.value.plain()}, command.part)

    async def _send_raw(self, command: RawCommand) -> None:
        self._check_link()
        self.raw_commands.append(command)

    def find_source(self, address: str) -> tuple[str, str]:
        """Return key and name of the device that reports raw messages on *address*, its own.

        Raises:
            RefusedError: Nobody may listen there.
        """
        return address, address

    def _check_link(self) -> None:
        if self._unavailable:
            raise LinkError(f"no device can be reached: {self._unavailable}")
