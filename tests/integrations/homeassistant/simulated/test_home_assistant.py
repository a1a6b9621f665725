"""A house that Home Assistant knows as well, or alone."""

import socket
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from tests.house.onlooker import house
from tests.integrations.homeassistant.simulated.entity import ServedEntity
from tests.integrations.homeassistant.simulated.server import SimulatedHomeAssistant
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE

from homebot.devices import Device, Devices
from homebot.devices.handles import Light
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

pytestmark = pytest.mark.slow

KINDS = ("contact", "cover", "lamp", "lock", "lux", "motion", "power_meter", "thermostat", "window")


@asynccontextmanager
async def serving(home: SimulatedHomeAssistant, kinds: Iterable[str]) -> AsyncIterator[None]:
    """Let a Home Assistant have these devices of the house too."""
    async with anyio.create_task_group() as tasks:
        await tasks.start(home.serve)
        for kind in kinds:
            entity = ServedEntity(SimulatedDeviceInfo("home425", kind, kind, kind, "hall"), lambda _: None, home)
            entity.begin(DeviceState(text="off"), has_power=True)
            await tasks.start(entity.serve)
        yield
        tasks.cancel_scope.cancel()


async def found(node: Node, *gateways: str) -> tuple[Device, ...]:
    """Wait until all devices are found, each by these gateways, the ones that take its commands first."""
    with anyio.fail_after(PATIENCE):
        while True:
            devices = await Devices(node).find()
            ways = [tuple(one.gateway for one in part.routes) for device in devices for part in device.parts]
            if ways == [gateways] * len(KINDS):
                return devices
            await anyio.sleep(0.05)


@pytest.mark.parametrize("dialect", ["homeassistant", "homeassistant_device"])
async def test_a_house_that_home_assistant_has_too_has_each_device_once_and_its_own_protocol_first(
    dialect: str, tmp_path: Path
) -> None:
    tables = {kind: {"kind": kind, "dialect": dialect} for kind in KINDS}
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        home = SimulatedHomeAssistant(port=probe.getsockname()[1])
    home.floors["hall"] = "Ground floor"
    token = tmp_path / "token"
    token.touch(mode=0o600)
    token.write_text(home.token)
    table = {"url": f"http://127.0.0.1:{home.server.port}", "token_file": str(token)}
    async with alone_on_loopback(), house(tables, {"homeassistant": table}) as (node, _):
        await found(node, "mqtt")
        async with serving(home, KINDS):
            devices = await found(node, "mqtt", "homeassistant")
            (light,) = await Devices(node).find(Light, area="Ground floor")
    assert sorted(one.name for one in devices) == sorted(KINDS)
    assert {(one.area, one.outer_areas[:-1]) for one in devices} == {("hall", ("Ground floor",))}
    assert light.name == "lamp"
