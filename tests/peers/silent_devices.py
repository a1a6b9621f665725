"""Simulated devices of all drivers, as a program that a test stops or takes off the network; it prints their ports."""

import json
import sys

import anyio
from tests.integrations.esphome.simulated.device import EsphomeServedDevice
from tests.integrations.shelly.simulated.web_device import ServedShelly
from tests.integrations.wled.simulated.web_device import ServedWled
from tests.things.thing import ServedThing

from homebot.house.dialect import SimulatedDeviceInfo


def _ignore(command: str) -> None:
    del command


async def main(address: str) -> None:
    info = SimulatedDeviceInfo("home", "lamp", "hall", "lights", "hall")
    esphome = EsphomeServedDevice(info, _ignore, host=address)
    web: dict[str, ServedShelly | ServedWled | ServedThing] = {
        "shelly": ServedShelly(info, _ignore, address=address),
        "wled": ServedWled(info, _ignore, address=address),
        "thing": ServedThing(info, _ignore, address=address),
    }
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(esphome.serve)
        for device in web.values():
            await tasks.start(device.serve)
        await esphome.listening.wait()
        ports = {name: device.server.port for name, device in web.items()}
        print("ports", json.dumps({**ports, "esphome": esphome.port}), flush=True)  # noqa: T201 - for the test


anyio.run(main, sys.argv[1])
