"""The client of Home Assistant for Shelly takes the simulated dimmer for a real one."""

import pytest
from tests.integrations.shelly.simulated.web_device import ServedShelly
from tests.peers.network import Lan, Machine
from tests.peers.other_python import python_with
from tests.peers.served_device import LAMP, facts_in, served

from homebot.house.dialect import DeviceState

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
"""A program on aioshelly: what it sees and does, one JSON text each line."""


@pytest.fixture(scope="session")
def shelly_python() -> str:
    return python_with("aioshelly", "3.13", "3.12")


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
        seen = facts_in(await lan.machine("client").run(shelly_python, "-c", SHELLY_CLIENT, *arguments))
    assert seen[0] == {"id": dimmer.id, "gen": 3, "auth": bool(password)}
    assert seen[1] == {"name": "Shelf", "status": False, "firmware": "20241011-114449/1.4.4-g6d2a586"}
    assert seen[2:] == [{"pushed": True}]


async def test_the_client_of_shelly_is_not_let_in_with_a_wrong_password(
    shelly_python: str, lan: Lan, hub: Machine
) -> None:
    dimmer = ServedShelly(LAMP, lambda _: None, address=hub.address, password="secret")
    async with served(dimmer):
        arguments = (hub.address, str(dimmer.server.port), "wrong")
        seen = facts_in(await lan.machine("client").run(shelly_python, "-c", SHELLY_CLIENT, *arguments))
    assert seen[-1] == {"error": "InvalidAuthError"}
