"""A gateway in memory, for devices with raw messages that a test plays."""

from typing import ClassVar, Literal

from pydantic import BaseModel

from homebot.errors import RefusedError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.base import GatewayContext
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Node


class FakeGatewaySettings(MemoryGatewaySettings):
    """The settings of the fake."""

    refused: tuple[str, ...] = ()


class FakeGateway(MemoryGateway):
    """A gateway for devices ``SERVICE_TYPE/DEVICE_ID`` that publish on ``KEY/out`` and take commands on ``KEY/in``."""

    Settings: ClassVar[type[BaseModel]] = FakeGatewaySettings

    def __init__(
        self, node: Node, settings: FakeGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        self._refused = (settings or FakeGatewaySettings()).refused
        super().__init__(node, settings or FakeGatewaySettings(), context)

    @property
    def told(self) -> list[tuple[str, str]]:
        """The addresses and payloads of received raw commands, oldest first."""
        return [(command.address, command.payload) for command in self.raw_commands]

    async def says(self, key: str, payload: str | bytes, *, name: str = "", takes_commands: bool = True) -> None:
        """Publish *payload* as the device *key*, which is announced, to its subscribers."""
        self.sees(key, name=name, takes_commands=takes_commands)
        await self.devices.deliver_raw(key, payload.encode() if isinstance(payload, str) else payload)

    def sees(
        self,
        key: str,
        *,
        kind: Literal["appeared", "updated", "removed"] = "updated",
        service_type: str = "",
        name: str = "",
        takes_commands: bool = True,
        confirmed: bool = True,
    ) -> None:
        """Announce the device *key*; its service type is the first part of its key unless given."""
        if kind == "removed":
            self.removes(key)
            return
        device = GatewayDevice(
            key,
            name or key.rpartition("/")[2],
            service_type=service_type or key.partition("/")[0],
            address=f"{key}/out",
            command_address=f"{key}/in" if takes_commands else "",
        )
        self.devices.put(device, "the test says so", confirmed=confirmed)

    def removes(self, key: str) -> None:
        """Remove the device *key* from the house."""
        self.devices.remove(key, "the test says so")

    def find_source(self, address: str) -> tuple[str, str]:
        """Return key and name of the device that publishes on *address*.

        Raises:
            RefusedError: The settings forbid it.
        """
        if address in self._refused:
            raise RefusedError(f"listening to {address}", "the test refuses it")
        key = address.removesuffix("/out")
        return key, key.rpartition("/")[2]
