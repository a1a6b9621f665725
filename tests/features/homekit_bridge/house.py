"""A house with a bridge for HomeKit, in one process: devices in memory, the directory and the control layer."""

from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path

import anyio

from homebot.control import Control
from homebot.control.settings import ControlSettings
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.discovery import Directory, DirectorySettings
from homebot.features.homekit_bridge import GET_PAIRING, UNPAIR
from homebot.features.homekit_bridge.bridge import HomekitBridges
from homebot.features.homekit_bridge.hap import HapBridge
from homebot.features.homekit_bridge.messages import (
    GetHomekitPairing,
    HomekitPairingRequest,
    HomekitPairingResponse,
    HomekitUnpairRequest,
    HomekitUnpairResponse,
    UnpairHomekit,
)
from homebot.features.homekit_bridge.settings import HomekitBridgeSettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.gateways.pairing import PairingFile
from homebot.graph import Graph, Node

LAMP = simple_part("light", settable=("on_off", "level"))
LOCK = Part(
    id="",
    service_type="door_lock",
    capabilities=(Capability(name="lock", settable=True, options=("locked", "unlocked")),),
)


class Gateway(MemoryGateway):
    """A gateway of which the devices in *stubborn* report on that they are off, those in *silent* nothing."""

    stubborn: frozenset[str] = frozenset()
    silent: frozenset[str] = frozenset()

    async def _perform(self, command: Command) -> None:
        if command.key in self.stubborn:
            await self.devices.report(command.key, {"on_off": False})
        elif command.key not in self.silent:
            await super()._perform(command)


class BridgedHouse:
    """The house.

    Attributes:
        bridges: What is tested.
    """

    def __init__(self, gateway: Gateway, app: Node, bridges: HomekitBridges) -> None:
        self.gateway, self.bridges = gateway, bridges
        self._pairing = app.create_client(GetHomekitPairing, GET_PAIRING.name)
        self._unpair = app.create_client(UnpairHomekit, UNPAIR.name)

    async def put(self, key: str, part: Part, name: str = "", **values: PlainValue) -> None:
        """Put a device, perhaps with another name than before."""
        self.gateway.devices.put(GatewayDevice(key, name or key.replace("_", " ").capitalize(), (part,)), "it is there")
        if values:
            await self.report(key, **values)

    async def report(self, key: str, **values: PlainValue) -> None:
        await self.gateway.devices.report(key, values)

    async def pairing(self) -> HomekitPairingResponse:
        return await self._pairing.call(HomekitPairingRequest())

    async def unpair(self) -> HomekitUnpairResponse:
        return await self._unpair.call(HomekitUnpairRequest())


@asynccontextmanager
async def bridged_house(
    file: Path | None,
    parts: Mapping[str, Part],
    make: Callable[..., HapBridge] = HapBridge,
    **settings: object,
) -> AsyncIterator[BridgedHouse]:
    """Open a house with *parts* by the keys of their devices; *settings* are those of ``[homekit_bridge]``."""
    graph = Graph()
    async with (
        Node(graph, "memory", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "control") as control_node,
        Node(graph, "homekit_bridge") as node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        gateway = Gateway(gateway_node)
        checked = HomekitBridgeSettings.model_validate({"port": 0, **settings})
        bridges = HomekitBridges(node, checked, PairingFile(file), "Villa", make)
        house = BridgedHouse(gateway, app, bridges)
        await tasks.start(gateway.serve)
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        await tasks.start(Control(control_node, ControlSettings(approvals=False)).serve)
        for key, part in parts.items():
            await house.put(key, part)
            if part is LAMP:
                await house.report(key, on_off=False)
        await tasks.start(bridges.serve)
        yield house
        tasks.cancel_scope.cancel()
