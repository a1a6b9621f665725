"""The reference gateway: devices that exist in this process alone. No socket, so it runs in virtual time as well.

It shows the duties of a gateway: keep one :class:`PublishedDevices`, put and remove devices, read their messages and
charge them for broken rules, carry out commands, and publish the state of its link.
"""

from collections import deque
from collections.abc import Collection
from typing import Annotated, ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, Field

from homebot.conventions.payload import parse_object
from homebot.devices import RawCommand
from homebot.devices.capabilities import implied_settings
from homebot.devices.exposure import ExposedDevice
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, WireError
from homebot.gateways.announced.exposed_devices import ExposedDevices, KnownStates
from homebot.gateways.announced.published_devices import MAX_DEVICES, PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings
from homebot.graph import Node

KEPT = 1000
"""Commands that are remembered; the oldest goes."""


class MemoryGatewaySettings(GatewaySettings):
    """The table ``[gateways.NAME]`` of a gateway in memory.

    Attributes:
        max_devices: Devices that may be known at once.
    """

    max_devices: Annotated[int, Field(ge=1)] = MAX_DEVICES


class MemoryGateway(Gateway):
    """A gateway with simulated devices: they carry out each command and report it.

    Attributes:
        commands: The commands that it carried out, oldest first; at most 1,000.
        exposed: The devices that homebot exposes through it, by id, each with the states that are known of it.
    """

    Settings: ClassVar[type[BaseModel]] = MemoryGatewaySettings

    def __init__(
        self, node: Node, settings: MemoryGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        settings = settings or MemoryGatewaySettings()
        super().__init__(node, settings, context)
        self.commands: deque[Command] = deque(maxlen=KEPT)
        self.raw_commands: deque[RawCommand] = deque(maxlen=KEPT)
        self.exposed: dict[str, tuple[ExposedDevice, KnownStates]] = {}
        self.devices = PublishedDevices(
            self,
            self._perform,
            settings,
            send_raw=self._send_raw,
            find_source=self.find_source,
            max_devices=settings.max_devices,
        )
        log = self.devices.engine.quarantine.log_limited
        self._exposed = ExposedDevices(self, self._show, self._publish_states, log) if settings.act else None
        self._unavailable = ""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Publish the state, and wait until cancelled."""
        self.publish_state("unavailable" if self._unavailable else "active", self._unavailable)
        task_status.started()
        await anyio.sleep_forever()

    async def receive(self, key: str, payload: bytes) -> None:
        """Handle a raw message of a device: the values of its part by capability, as a JSON object."""
        if not self.devices.admits(key):
            return
        try:
            values = {name: _plain(value) for name, value in parse_object(payload).items()}
        except WireError as exc:
            self.devices.reject(key, payload, str(exc))
            return
        await self.devices.deliver_raw(key, payload)
        await self.devices.report(key, values)

    def command_exposed(self, command: Command) -> None:
        """Command an exposed device as another system; its id is the command's key."""
        if self._exposed is not None:
            self._exposed.command(command)

    def set_available(self) -> None:
        """Make the devices reachable again."""
        self._unavailable = ""
        self.publish_state("active")

    def set_unavailable(self, reason: str) -> None:
        """Make all devices unreachable, for a *reason* as text; they stay registered."""
        self._unavailable = reason
        self.publish_state("unavailable", reason)

    async def _perform(self, command: Command) -> None:
        self._check_link()
        self.commands.append(command)
        part = self.devices.engine.find_part(command.key, command.part).described.part
        settable = {capability.name for capability in part.capabilities if capability.settable}
        settings = implied_settings(command.capability, command.value.plain(), settable)
        await self.devices.report(command.key, dict(settings), command.part)

    async def _send_raw(self, command: RawCommand) -> None:
        self._check_link()
        self.raw_commands.append(command)

    def find_source(self, address: str) -> tuple[str, str]:
        """Return key and name of the device that reports raw messages on *address*."""
        return self.devices.owner_of(address)

    def _show(self, offer: ExposedDevice) -> None:
        if offer.is_withdrawn:
            self.exposed.pop(offer.id, None)
        else:
            self.exposed[offer.id] = offer, {}

    def _publish_states(self, offer: ExposedDevice, known: KnownStates, changed: Collection[tuple[str, str]]) -> None:
        del changed
        self.exposed[offer.id] = offer, dict(known)

    def _check_link(self) -> None:
        if self._unavailable:
            raise LinkError(f"no device can be reached: {self._unavailable}")


def _plain(value: object) -> PlainValue:
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        return float(value)
    raise WireError(f"a value is a {type(value).__name__}")
