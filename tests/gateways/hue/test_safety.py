"""Lamps behind a Hue bridge obey rights, quiet hours and leases."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import anyio.to_thread
import pytest
from tests.gateways.hue.bridges import bridge_with_certificate, pairings_of
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.handles import Light
from homebot.devices.names import PERFORM_COMMAND
from homebot.devices.outcomes import Refused
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.hue import HueHouseDevice, SimulatedHueBridge
from homebot.runtime import Runtime

pytestmark = pytest.mark.slow

HALVES = ("00:00", "12:00")


@asynccontextmanager
async def homebot(
    folder: Path, *, trusts_apps: bool = False, **control: object
) -> AsyncIterator[tuple[SimulatedHueBridge, Node, Light]]:
    """Run homebot until the block ends: the bridge, a node, and the lamp behind the bridge."""
    bridge, certificate = await anyio.to_thread.run_sync(bridge_with_certificate)

    def obey(order: str) -> None:
        lamp.publish(DeviceState(text=order, is_on=order == "on"))

    lamp = HueHouseDevice(SimulatedDeviceInfo("home", "lamp", "Lamp", "x", "Hall"), obey, bridge)
    lamp.begin(DeviceState(text="off"), has_power=True)
    async with anyio.create_task_group() as tasks:
        await tasks.start(bridge.serve)
        await tasks.start(lamp.serve)
        pairings = await anyio.to_thread.run_sync(pairings_of, bridge, certificate, folder)
        gateways = {"hue": {"pairings": str(pairings)}}
        tables = {"gateways": gateways, "discovery": {"persist": False}, "control": control}
        async with (
            Runtime(parse_config(tables, "test"), with_door=False, trusts_apps=trusts_apps) as runtime,
            Node(runtime.graph, "watcher") as node,
        ):
            with anyio.fail_after(PATIENCE):
                light = await anext(change.handle async for change in Devices(node).follow(Light))
            yield bridge, node, light
        tasks.cancel_scope.cancel()


async def refusal(node: Node, light: Light, *scope: str) -> str:
    """Turn the lamp on as a client with the rights of *scope*; return the policy that refuses, empty for none."""
    settings = (Setting.of("on_off", plain=True),)
    request = CommandRequest(device=light.device.id, settings=settings, issuer="client:phone", scope=scope)
    outcome = await node.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=PATIENCE)
    return outcome.policy if isinstance(outcome, Refused) else ""


def turned_on(bridge: SimulatedHueBridge) -> bool:
    return any(body.get("on") == {"on": True} for _, _, body in bridge.commands)


async def test_a_client_without_the_right_is_refused(tmp_path: Path) -> None:
    async with homebot(tmp_path) as (bridge, node, light):
        assert await refusal(node, light, "act: vacuum") == "rights"
        assert not turned_on(bridge)
        assert await refusal(node, light, "act: light in hall") == ""
        assert turned_on(bridge)


async def test_quiet_hours_hold_for_apps(tmp_path: Path) -> None:
    hours = [{"start": one, "end": other, "commands": ["use light"]} for one, other in (HALVES, HALVES[::-1])]
    async with homebot(tmp_path, trusts_apps=True, quiet_hours=hours) as (bridge, node, light):
        outcome = await light.turn_on()
        assert isinstance(outcome, Refused)
        assert outcome.policy == "quiet_hours"
        assert not turned_on(bridge)
        assert await refusal(node, light, "act: all") == ""


async def test_a_lease_holds(tmp_path: Path) -> None:
    async with homebot(tmp_path, trusts_apps=True) as (bridge, node, light):
        async with light.hold("off", by="guard"):
            assert await refusal(node, light, "act: all") == "lease"
            assert not turned_on(bridge)
        assert await refusal(node, light, "act: all") == ""
