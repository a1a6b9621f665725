"""aiohue, the client that Home Assistant uses, takes the simulated Hue bridge for a real one."""

import json
import subprocess
from dataclasses import replace

import anyio
import anyio.to_thread
import pytest
from tests.integrations.hue.gateway.bridges import bridge_with_certificate, button, buttons
from tests.integrations.hue.simulated.bridge import HueHouseDevice, SimulatedHueBridge
from tests.patience import PATIENCE
from tests.peers.other_python import python_with

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

CLIENT = """
import asyncio
import json
import logging
import sys

from aiohue.util import create_app_key
from aiohue.v2 import HueBridgeV2
from aiohue.v2.models.feature import ColorFeatureBase, ColorPoint, GradientFeatureBase, GradientPoint
from aiohue.v2.models.light import LightPut

WITHIN = 30


class Complaints(logging.Handler):
    lines = []

    def emit(self, record):
        self.lines.append(self.format(record))


async def main(host):
    logging.getLogger().addHandler(Complaints(logging.WARNING))
    key = await create_app_key(host, "peer#test")
    async with HueBridgeV2(host, key) as bridge:
        changed = asyncio.Event()
        events = []

        def see(kind, item):
            events.append([kind.value, item.type.value])
            changed.set()

        async def until(holds):
            async with asyncio.timeout(WITHIN):
                while not holds():
                    changed.clear()
                    await changed.wait()

        bridge.subscribe(see)
        async with asyncio.timeout(WITHIN):
            while not bridge.events.connected:
                await asyncio.sleep(0.01)
        facts = {
            "bridge": bridge.bridge_id,
            "devices": sorted(one.metadata.name for one in bridge.devices),
            "rooms": {one.metadata.name: len(one.children) for one in bridge.groups.room},
            "scenes": sorted(one.metadata.name for one in bridge.scenes),
            "sensors": sorted({one.type.value for one in bridge.sensors}),
        }
        light = next(one for one in bridge.lights if one.supports_color and not one.gradient)
        strip = next(one for one in bridge.lights if one.gradient)
        plug = next(one for one in bridge.lights if not one.supports_dimming)
        await bridge.lights.set_state(light.id, on=True, brightness=50)
        await bridge.lights.set_state(light.id, color_temp=300)
        await until(lambda: light.is_on and light.brightness == 50 and light.color_temperature.mirek == 300)
        await bridge.lights.set_state(light.id, color_xy=(0.3, 0.3))
        await until(lambda: not light.color_temperature.mirek_valid and light.color.xy.x == 0.3)
        points = [GradientPoint(ColorFeatureBase(ColorPoint(x, 0.3))) for x in (0.2, 0.4, 0.6)]
        await bridge.lights.update(strip.id, LightPut(gradient=GradientFeatureBase(points)))
        await until(lambda: len(strip.gradient.points) == 3 and strip.color.xy.x == 0.2)
        await bridge.lights.set_state(strip.id, color_xy=(0.5, 0.3))
        await until(lambda: not strip.gradient.points and strip.color.xy.x == 0.5)
        await bridge.lights.turn_on(plug.id)
        await until(lambda: plug.is_on)
        group = next(iter(bridge.groups.room)).grouped_light
        await bridge.groups.grouped_light.set_state(group, on=False)
        await until(lambda: not (light.is_on or strip.is_on or plug.is_on))
        await bridge.groups.grouped_light.set_state(group, on=True, brightness=70)
        await until(lambda: light.brightness == strip.brightness == 70 and plug.is_on)
        scene = next(one for one in bridge.scenes if one.metadata.name == "Dimmed")
        await bridge.scenes.recall(scene.id)
        await until(lambda: scene.status.active.value == "static" and light.brightness == 30)
        print(json.dumps("press a button of the dimmer"), flush=True)
        await until(lambda: ["update", "button"] in events)
        pressed = [one.button.value.value for one in bridge.sensors.button if one.button.button_report]
        print(json.dumps(facts | {"pressed": pressed, "complaints": Complaints.lines}), flush=True)


asyncio.run(main(sys.argv[1]))
"""
"""A program on aiohue: pairs by the button, reads everything, commands, and prints its findings and all warnings."""


@pytest.fixture(scope="session")
def hue_python() -> str:
    return python_with("aiohue", "3.11", "3.12", "3.13")


def device(bridge: SimulatedHueBridge, kind: str, at: str = "") -> HueHouseDevice:
    def obey(order: str) -> None:
        if order.endswith(" K"):
            made.publish(replace(made.state, kelvin=float(order.removesuffix(" K"))))
        elif order in {"on", "off"}:
            made.publish(replace(made.state, is_on=order == "on"))
        else:
            made.publish(replace(made.state, is_on=True, brightness=float(order)))

    info = SimulatedDeviceInfo("home", kind, f"The {at or kind}", "x", "Hall")
    made = HueHouseDevice(info, obey, bridge, at)
    made.begin(DeviceState(text="off"), has_power=True)
    return made


@pytest.mark.newest("hue")
async def test_aiohue_pairs_reads_and_commands_without_a_complaint(hue_python: str) -> None:
    bridge, _ = await anyio.to_thread.run_sync(bridge_with_certificate)
    kinds = (("lamp", ""), ("lamp", "plug"), ("lamp", "gradient"), ("motion", ""), ("lux", ""), ("contact", ""))
    async with anyio.create_task_group() as tasks:
        await tasks.start(bridge.serve)
        for kind, at in kinds:
            await tasks.start(device(bridge, kind, at).serve)
        bridge.add(buttons(button(1), button(2)))
        bridge.press_button()
        command = [hue_python, "-c", CLIENT, f"127.0.0.1:{bridge.server.port}"]
        with anyio.fail_after(2 * PATIENCE):
            async with await anyio.open_process(command, stderr=subprocess.STDOUT) as client:
                assert client.stdout is not None
                printed = ""
                async for chunk in client.stdout:
                    printed += chunk.decode()
                    if printed.endswith('"press a button of the dimmer"\n'):
                        bridge.press("button-of-1", "short_release")
        tasks.cancel_scope.cancel()
    last = printed.splitlines()[-1]
    assert last.startswith("{"), printed
    assert json.loads(last) == {
        "bridge": bridge.id,
        "devices": [
            "Dimmer",
            "Hue bridge",
            "The contact",
            "The gradient",
            "The lamp",
            "The lux",
            "The motion",
            "The plug",
        ],
        "rooms": {"Hall": 6},
        "scenes": ["Bright", "Dimmed"],
        "sensors": ["button", "contact", "device_power", "light_level", "motion", "tamper", "zigbee_connectivity"],
        "pressed": ["short_release"],
        "complaints": [],
    }
