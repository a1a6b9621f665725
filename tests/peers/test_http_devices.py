"""The makers' own clients take the simulated devices for real ones."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.peers.network import Lan, Machine
from tests.peers.other_python import python_with

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.shelly.simulated.web_device import ServedShelly
from homebot.integrations.wled.simulated import ServedWled

WLED_CLIENT = """
import asyncio
import json
import sys

from wled import WLED


def show(**facts):
    print(json.dumps(facts), flush=True)


async def main(address):
    async with WLED(address) as wled:
        device = await wled.update()
        show(
            name=device.info.name,
            mac=device.info.mac_address,
            version=str(device.info.version),
            lights=int(device.info.leds.light_capabilities),
            effects=[one.name for one in device.effects.values()],
            on=device.state.on,
            segments=sorted(device.state.segments),
        )
        await wled.connect()
        pushed = asyncio.Event()

        def see(device):
            if device.state.on and device.state.brightness == 128:
                pushed.set()

        listener = asyncio.ensure_future(wled.listen(callback=see))
        await wled.master(on=True, brightness=128)
        await asyncio.wait_for(pushed.wait(), 60)
        await wled.segment(0, color_primary=(0, 0, 255), effect="Rainbow")
        device = await wled.update()
        show(pushed=True, color=device.state.segments[0].color.primary, effect=device.state.segments[0].effect_id)
        listener.cancel()


asyncio.run(main(sys.argv[1]))
"""
"""A program on the official client of WLED: what it sees and does, one JSON text each line."""

SHELLY_CLIENT = """
import asyncio
import json
import sys

import aiohttp
from aioshelly.common import ConnectionOptions, get_info
from aioshelly.rpc_device import RpcDevice, RpcUpdateType


def show(**facts):
    print(json.dumps(facts), flush=True)


async def main(address, port, password):
    async with aiohttp.ClientSession() as session:
        about = await get_info(session, address, port=port)
        show(id=about["id"], gen=about["gen"], auth=about["auth_en"])
        login = {"username": "admin", "password": password} if password else {}
        device = await RpcDevice.create(session, None, ConnectionOptions(address, port=port, **login))
        pushed = asyncio.Event()

        def see(_device, kind):
            if kind is RpcUpdateType.STATUS and device.status["light:0"]["output"]:
                pushed.set()

        device.subscribe_updates(see)
        try:
            await device.initialize()
            show(name=device.name, status=device.status["light:0"]["output"], firmware=device.firmware_version)
            await device.call_rpc("Light.Set", {"id": 0, "on": True})
            await asyncio.wait_for(pushed.wait(), 60)
            show(pushed=True)
        except Exception as exc:
            show(error=type(exc).__name__)
        finally:
            await device.shutdown()


asyncio.run(main(sys.argv[1], int(sys.argv[2]), sys.argv[3]))
"""
"""Likewise of Shelly."""

LAMP = SimulatedDeviceInfo("home", "lamp", "Shelf", "lights", "hall")


@asynccontextmanager
async def served(device: ServedShelly | ServedWled) -> AsyncIterator[None]:
    device.begin(DeviceState(text="off", brightness=0.4), has_power=True)
    async with anyio.create_task_group() as tasks:
        await tasks.start(device.serve)
        yield
        tasks.cancel_scope.cancel()


def lines(printed: str) -> list[dict[str, object]]:
    try:
        return [json.loads(line) for line in printed.splitlines()]
    except ValueError:
        pytest.fail(f"the client printed {printed}")


@pytest.fixture(scope="session")
def wled_python() -> str:
    return python_with("wled", "3.11", "3.12", "3.13")


@pytest.fixture(scope="session")
def shelly_python() -> str:
    return python_with("aioshelly", "3.13", "3.12")


async def test_the_client_of_wled_reads_the_strip_and_is_pushed_what_it_commands(
    wled_python: str, lan: Lan, hub: Machine
) -> None:

    def obey(text: str) -> None:
        if text == "off":
            strip.publish(DeviceState(text="off", brightness=strip.state.brightness))
        elif not text.endswith("K"):
            brightness = strip.state.brightness if text == "on" else float(text)
            strip.publish(DeviceState(text="on", is_on=True, brightness=brightness))

    strip = ServedWled(LAMP, obey, address=hub.address, port=80)
    async with served(strip):
        first, last = lines(await lan.machine("client").run(wled_python, "-c", WLED_CLIENT, hub.address))
    assert first == {
        "name": "Shelf",
        "mac": strip.mac,
        "version": "0.15.0",
        "lights": 5,
        "effects": ["Solid", "Blink", "Breathe", "Wipe", "Rainbow"],
        "on": False,
        "segments": [0],
    }
    assert last == {"pushed": True, "color": [0, 0, 255], "effect": 5}


@pytest.mark.parametrize("password", ["", "secret"])
async def test_the_client_of_shelly_reads_the_dimmer_and_is_pushed_what_it_commands(
    shelly_python: str, lan: Lan, hub: Machine, password: str
) -> None:
    dimmer = ServedShelly(
        LAMP,
        lambda text: dimmer.publish(DeviceState(text=text, is_on=text == "on", brightness=0.4)),
        address=hub.address,
        password=password,
    )
    async with served(dimmer):
        arguments = (hub.address, str(dimmer.server.port), password)
        seen = lines(await lan.machine("client").run(shelly_python, "-c", SHELLY_CLIENT, *arguments))
    assert seen[0] == {"id": dimmer.id, "gen": 3, "auth": bool(password)}
    assert seen[1] == {"name": "Shelf", "status": False, "firmware": "20241011-114449/1.4.4-g6d2a586"}
    assert seen[2:] == [{"pushed": True}]


async def test_the_client_of_shelly_is_not_let_in_with_a_wrong_password(
    shelly_python: str, lan: Lan, hub: Machine
) -> None:
    dimmer = ServedShelly(LAMP, lambda _: None, address=hub.address, password="secret")
    async with served(dimmer):
        arguments = (hub.address, str(dimmer.server.port), "wrong")
        seen = lines(await lan.machine("client").run(shelly_python, "-c", SHELLY_CLIENT, *arguments))
    assert seen[-1] == {"error": "InvalidAuthError"}
