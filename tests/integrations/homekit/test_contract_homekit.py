"""The HomeKit gateway keeps the contract, with a paired accessory behind its port."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

import pytest
from tests.integrations.homekit.gateway.fake_accessories import FakeMdns, FakePort, FakeServer, accessory, lamp_service

from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.gateways import Gateway, GatewayContext
from homebot.graph import Node
from homebot.integrations.homekit.gateway import HomekitGateway, HomekitGatewaySettings
from homebot.integrations.homekit.gateway.port import HomekitPort
from homebot.testing.gateway_contract import GatewayContract, Lamp

pytestmark = pytest.mark.virtual_time

KEY = "AA:BB:CC:DD:EE:01"
ON, LEVEL, HUE, SATURATION, MIREDS = ((1, iid) for iid in range(9, 14))


class HomekitLamp(Lamp):
    """A lamp that was paired before it comes into the house."""

    settings: ClassVar[Mapping[str, PlainValue]] = {"level": 40.0, "color": (120.0, 80.0), "color_temperature": 2700.0}
    together = LIGHT_CAPABILITIES

    def __init__(self, pairings: Path) -> None:
        super().__init__(KEY, "8", address=f"homekit/{KEY}")
        self.server = FakeServer(KEY, "Hall", accessory(1, "Hall", lamp_service()))
        self.server.knows_homebot = True
        self.pairings = pairings
        pairings.write_text(json.dumps({KEY: {"secret": "c0ffee"}}))
        pairings.chmod(0o600)
        self.mdns: FakeMdns | None = None
        self._problem = ""
        self._is_announced = False

    def enter(self, node: Node) -> None:
        if self.mdns is None or self.mdns.node.graph is not node.graph:
            self.mdns = FakeMdns(node.graph)
            self.mdns.state(self._problem)

    async def announce(self) -> None:
        assert self.mdns is not None
        self.mdns.announce(self.server)

    async def report(self, *, on: bool) -> None:
        self.server.report(*ON, on)

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"aid": 1, "iid": 9, "value": on}, separators=(",", ":")).encode()

    async def misbehave(self) -> None:
        assert self.mdns is not None
        for number in range(2000):
            self.mdns.sight(f"stranger {number}", dns_sd_type="_hap._tcp", txt_id="?" * 1000)

    async def withdraw(self) -> None:
        self.server.drop()

    async def told(self) -> bool | None:
        written = [value for at, value in self.server.written if at == ON]
        return bool(written[-1]) if written else None

    async def told_value(self, capability: str) -> PlainValue:
        written = {at: float(str(value)) for at, value in self.server.written if at != ON}
        match capability:
            case "level":
                return written.get(LEVEL)
            case "color":
                return (written[HUE], written[SATURATION]) if HUE in written else None
            case _:
                return 1e6 / written[MIREDS] if MIREDS in written else None

    async def lose_link(self) -> None:
        self._lose("the cable was pulled")
        self.server.is_there = False
        self.server.drop()

    async def mend_link(self) -> None:
        self.server.is_there = True
        self._lose("")

    def _lose(self, problem: str) -> None:
        self._problem = problem
        if self.mdns is not None:
            self.mdns.state(problem)


class TestHomekitGateway(GatewayContract):
    """One lamp."""

    name = "homekit"
    time_is_virtual = True
    tells_goodbye = False

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        with TemporaryDirectory() as folder:
            yield HomekitLamp(Path(folder) / "pairings.json")

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, HomekitLamp)
        lamp.enter(node)
        context = GatewayContext(services={HomekitPort: FakePort(lamp.server)})
        table = {"pairings": str(lamp.pairings), **settings}
        return HomekitGateway(node, HomekitGatewaySettings.model_validate(table), context)
