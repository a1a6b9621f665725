"""The gateway to Hue bridges keeps the contract, with a simulated bridge over HTTPS."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

import anyio.to_thread
from anyio.abc import TaskGroup
from tests.gateways.served import ServedLamp, with_server
from tests.integrations.hue.gateway.bridges import bridge_with_certificate, pairings_of
from tests.integrations.hue.simulated.bridge import HueHouseDevice, SimulatedHueBridge

from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.conventions.light_color import to_hue_saturation
from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.hue.gateway import HueGateway, HueGatewaySettings
from homebot.testing.gateway_contract import GatewayContract, Lamp

INFO = SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "")


class HueLamp(ServedLamp):
    """A lamp behind a bridge that homebot is paired with."""

    settings: ClassVar[Mapping[str, PlainValue]] = {
        "level": 40.0,
        "color": (30.0, 60.0),
        "color_temperature": 2700.0,
        "effect": "candle",
        "locate": True,
    }
    together = LIGHT_CAPABILITIES

    server: SimulatedHueBridge
    device: HueHouseDevice

    def __init__(self, tasks: TaskGroup, folder: Path, bridge: SimulatedHueBridge, certificate: str) -> None:
        self.tasks = tasks
        self.folder = folder
        self.server, self.certificate = bridge, certificate
        self.server.resources.clear()  # the bridge itself is no device here: the suite knows one
        self.device = HueHouseDevice(INFO, lambda _: None, self.server)
        self.device.begin(DeviceState(text="off"), has_power=True)
        super().__init__(self.device.owner_id, "light", address=self.device.owner_id)
        self.light = self.device.resource_id("light")

    async def report(self, *, on: bool) -> None:
        self.server.change(self.light, {"on": {"on": not on}})
        self.server.change(self.light, {"on": {"on": on}})

    def raw(self, *, on: bool) -> bytes:
        owner = {"rid": self.key, "rtype": "device"}
        item = {"id": self.light, "type": "light", "owner": owner, "on": {"on": on}}
        return json.dumps(item, separators=(",", ":")).encode()

    async def misbehave(self) -> None:
        def send(number: int) -> None:
            change = {"id": f"stranger-{number}", "type": "light", "on": "?" * 5_000}
            self.server.send_text(f"data: {json.dumps([{'type': 'update', 'data': [change]}])}")

        await self.flood(send)

    async def withdraw(self) -> None:
        rids = [rid for rid, one in self.server.resources.items() if self.key in {rid, _owner(one)}]
        self.server.remove(rids)

    async def told(self) -> bool | None:
        told = [body["on"] for kind, _, body in self.server.commands if kind == "light" and "on" in body]
        return None if not told else told[-1] == {"on": True}

    async def told_value(self, capability: str) -> PlainValue:
        for kind, _, body in reversed(self.server.commands):
            match body:
                case {"dimming": {"brightness": level}} if capability == "level":
                    return float(level)
                case {"color": {"xy": {"x": x, "y": y}}} if capability == "color":
                    return to_hue_saturation("xy", (x, y), (2000, 6500))
                case {"color_temperature": {"mirek": mirek}} if capability == "color_temperature":
                    return 1e6 / float(mirek)
                case {"effects": {"effect": effect}} if capability == "effect":
                    return str(effect)
                case {"identify": {"action": "identify"}} if capability == "locate":
                    return kind == "device"
        return None


def _owner(resource: Mapping[str, object]) -> object:
    owner = resource.get("owner")
    return owner["rid"] if isinstance(owner, dict) else None


class TestHueGateway(GatewayContract):
    """One lamp."""

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        with TemporaryDirectory() as folder:
            bridge = await anyio.to_thread.run_sync(bridge_with_certificate)
            async with with_server(lambda tasks: HueLamp(tasks, Path(folder), *bridge)) as lamp:
                yield lamp

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, HueLamp)
        path = pairings_of(lamp.server, lamp.certificate, lamp.folder)
        return HueGateway(node, HueGatewaySettings.model_validate({"pairings": path, **settings}))
