"""The Matter gateway keeps the contract, on the WebSocket of a simulated Matter server."""

import json
from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from typing import ClassVar

from anyio.abc import TaskGroup
from tests.gateways.served import ServedLamp, with_server
from tests.integrations.matter.simulated.node import ServedMatterNode
from tests.integrations.matter.simulated.server import SimulatedMatterServer

from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.matter.gateway import MatterGateway, MatterGatewaySettings
from homebot.testing.gateway_contract import GatewayContract, Lamp


class RecordingNode(ServedMatterNode):
    """A node that takes all orders, and does what Matter makes of them: a colour leaves a lamp off."""

    def __init__(self, device: SimulatedDeviceInfo, server: SimulatedMatterServer) -> None:
        super().__init__(device, lambda _: None, server)
        self.told: bool | None = None
        self.values: dict[str, PlainValue] = {}

    def describe(self) -> dict[str, object]:
        """The lamp of the house is white; this one has hue and saturation as well."""
        self.attributes |= {"1/768/0": 0, "1/768/1": 0, "1/768/65532": 0b10001}
        return super().describe()

    def invoke(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        assert cluster in {3, 6, 8, 768}
        match command:
            case "On" | "Off":
                self.told = command == "On"
            case "MoveToLevelWithOnOff":
                self.values["level"] = float(str(payload["level"])) * 100 / 254
                self.told = bool(payload["level"])
            case "MoveToColorTemperature":
                self.values["color_temperature"] = 1e6 / float(str(payload["colorTemperatureMireds"]))
            case "MoveToHueAndSaturation":
                hue, saturation = (float(str(payload[name])) for name in ("hue", "saturation"))
                self.values["color"] = hue * 360 / 254, saturation * 100 / 254
            case "Identify":
                self.values["locate"] = True
            case _:
                return False
        return endpoint == 1


class MatterLamp(ServedLamp):
    """A lamp that is commissioned when it comes into the house."""

    settings: ClassVar[Mapping[str, PlainValue]] = {
        "level": 40.0,
        "color": (120.0, 80.0),
        "color_temperature": 2700.0,
        "locate": True,
    }
    together = LIGHT_CAPABILITIES

    server: SimulatedMatterServer
    device: RecordingNode

    def __init__(self, server: SimulatedMatterServer, tasks: TaskGroup) -> None:
        super().__init__("node-1", "1", address="matter/node-1")
        self.server = server
        self.tasks = tasks
        self.device = RecordingNode(SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall"), server)
        self.device.begin(DeviceState(text="off"), has_power=True)

    async def report(self, *, on: bool) -> None:
        self.device.change("1/6/0", on)

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"event": "attribute_updated", "data": [1, "1/6/0", on]}, separators=(",", ":")).encode()

    async def misbehave(self) -> None:
        await self.flood(
            lambda number: self.server.send_event("attribute_updated", [1000 + number, "1/6", "?" * 10_000])
        )

    async def withdraw(self) -> None:
        self.server.remove(self.device)

    async def told(self) -> bool | None:
        return self.device.told

    async def told_value(self, capability: str) -> PlainValue:
        return self.device.values.get(capability)


class TestMatterGateway(GatewayContract):
    """One lamp."""

    def lamp(self) -> AbstractAsyncContextManager[Lamp]:
        return with_server(lambda tasks: MatterLamp(SimulatedMatterServer(), tasks))

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, MatterLamp)
        return MatterGateway(node, MatterGatewaySettings.model_validate({"url": lamp.server.url, **settings}))
