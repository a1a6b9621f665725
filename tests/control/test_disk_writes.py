"""What is written to the disk, which may be an SD card: counted over half a simulated hour, for all files together."""

import itertools
import sys
from pathlib import Path

import anyio
import pytest

from homebot.control import Control, ControlSettings
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node

HOURS = 0.5
SENSORS = 30
MOST_A_DAY = 8_000_000
"""Handed to the system. A disk writes blocks of 4 KiB, twice as much, and may write 20 MB."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="/proc counts the bytes"),
]


def bytes_written() -> int:
    """Return the bytes that this process handed to the system to write."""
    fields = dict(line.split(": ") for line in Path("/proc/self/io").read_text(encoding="ascii").splitlines())
    return int(fields["wchar"])


@pytest.mark.virtual_time
async def test_a_day_of_sensors_and_commands_writes_less_than_8_mb(tmp_path: Path) -> None:
    """Thirty sensors report every five seconds, and a lamp takes two commands a minute."""
    graph = Graph()
    async with (
        Node(graph, "memory", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "control") as control_node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        gateway = MemoryGateway(gateway_node)
        control = Control(control_node, ControlSettings(approvals=False), journal_file=tmp_path / "journal.sqlite")
        await tasks.start(gateway.serve)
        await tasks.start(Directory(directory_node, DirectorySettings(), tmp_path / "index.sqlite").serve)
        await tasks.start(control.serve)
        for number in range(SENSORS):
            sensor = simple_part("temperature_sensor", readable=("temperature",))
            gateway.devices.put(GatewayDevice(f"s{number}", f"Sensor {number}", (sensor,)), "it is there")
        lamp = simple_part("light", settable=("on_off",))
        gateway.devices.put(GatewayDevice("lamp", "Lamp", (lamp,)), "it is there")
        await anyio.sleep(60)
        light = (await Devices(app).find(Light))[0]

        async def report(number: int) -> None:
            await anyio.sleep(number * 5 / SENSORS)
            for value in itertools.count():
                await gateway.devices.report(f"s{number}", {"temperature": 20.0 + value % 10})
                await anyio.sleep(5)

        for number in range(SENSORS):
            tasks.start_soon(report, number)
        before = bytes_written()
        for turn in range(int(HOURS * 120)):
            assert isinstance(await (light.turn_on() if turn % 2 else light.turn_off()), Confirmed)
            await anyio.sleep(30)
        written = bytes_written() - before
        tasks.cancel_scope.cancel()
    assert 0 < written * 24 / HOURS < MOST_A_DAY, f"{written * 24 / HOURS / 1e6:.1f} MB a day"
