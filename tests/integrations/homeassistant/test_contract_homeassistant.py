"""The Home Assistant gateway keeps the contract, on the WebSocket of a simulated Home Assistant."""

import json
from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest
from anyio.abc import TaskGroup
from tests.gateways.served import ServedLamp, with_server
from tests.integrations.homeassistant.simulated.entity import ServedEntity
from tests.integrations.homeassistant.simulated.server import SimulatedHomeAssistant

from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.conventions.payload import compact_json
from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.homeassistant.gateway import HomeAssistantGateway, HomeAssistantGatewaySettings
from homebot.testing.gateway_contract import GatewayContract, Lamp

INFO = SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall")
MORE = {"supported_color_modes": ["color_temp", "hs"], "supported_features": 4, "effect_list": ["rainbow", "off"]}
"""The lamp of the house is white; this one has hue, saturation and effects as well."""


class RecordingEntity(ServedEntity):
    """A lamp that takes all services of lamps, and keeps what they set."""

    def __init__(self, server: SimulatedHomeAssistant) -> None:
        super().__init__(INFO, lambda _: None, server)
        self.template = replace(self.template, fixed={**self.template.fixed, **MORE})
        self.told: bool | None = None
        self.values: dict[str, PlainValue] = {}

    def call(self, service: str, data: Mapping[str, object]) -> bool:
        assert service in {"turn_on", "turn_off"}
        self.told = service == "turn_on"
        number = {name: float(str(value)) for name, value in data.items() if isinstance(value, (int, float))}
        if "brightness" in number:
            self.values["level"] = number["brightness"] * 100 / 255
        if "color_temp_kelvin" in number:
            self.values["color_temperature"] = number["color_temp_kelvin"]
        if isinstance(color := data.get("hs_color"), list):
            self.values["color"] = tuple(map(float, color))
        if isinstance(effect := data.get("effect"), str):
            self.values["effect"] = effect
        return True


class HomeAssistantLamp(ServedLamp):
    """A lamp that is added to Home Assistant when it comes into the house."""

    settings: ClassVar[Mapping[str, PlainValue]] = {
        "level": 40.0,
        "color": (120.0, 80.0),
        "color_temperature": 2700.0,
        "effect": "rainbow",
    }
    together = LIGHT_CAPABILITIES

    server: SimulatedHomeAssistant
    device: RecordingEntity

    def __init__(self, server: SimulatedHomeAssistant, tasks: TaskGroup, folder: Path) -> None:
        super().__init__("home-Hall", "light_home-Hall", address="homeassistant/home-Hall")
        self.server = server
        self.tasks = tasks
        self.token_file = folder / "token"
        self.token_file.touch(mode=0o600)
        self.token_file.write_text(server.token)
        self.device = RecordingEntity(server)
        self.device.begin(DeviceState(text="off"), has_power=True)

    async def report(self, *, on: bool) -> None:
        self.server.send_states({"c": json.loads(self.raw(on=on))})

    def raw(self, *, on: bool) -> bytes:
        return compact_json({self.device.entity_id: {"+": {"s": "on" if on else "off"}}}).encode()

    async def misbehave(self) -> None:
        await self.flood(lambda number: self.server.send_states({"c": {f"light.strange_{number}": "?" * 10_000}}))

    async def withdraw(self) -> None:
        self.server.remove(self.device)

    async def told(self) -> bool | None:
        return self.device.told

    async def told_value(self, capability: str) -> PlainValue:
        return self.device.values.get(capability)


class TestHomeAssistantGateway(GatewayContract):
    """One lamp."""

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self.folder = tmp_path

    def lamp(self) -> AbstractAsyncContextManager[Lamp]:
        return with_server(lambda tasks: HomeAssistantLamp(SimulatedHomeAssistant(), tasks, self.folder))

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, HomeAssistantLamp)
        table = {"url": lamp.server.url, "token_file": str(lamp.token_file), **settings}
        return HomeAssistantGateway(node, HomeAssistantGatewaySettings.model_validate(table))
