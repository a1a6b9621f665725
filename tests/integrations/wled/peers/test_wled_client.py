"""The official client of WLED takes the simulated strip for a real one."""

import pytest
from tests.integrations.wled.simulated.web_device import ServedWled
from tests.peers.network import Lan, Machine
from tests.peers.other_python import python_with
from tests.peers.served_device import LAMP, facts_in, served

from homebot.house.dialect import DeviceState

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


@pytest.fixture(scope="session")
def wled_python() -> str:
    return python_with("wled", "3.11", "3.12", "3.13")


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
        first, last = facts_in(await lan.machine("client").run(wled_python, "-c", WLED_CLIENT, hub.address))
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
