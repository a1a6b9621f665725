"""A confirmed command to a lamp in memory, each beside the same command without the control layer: CPU time of each."""

from __future__ import annotations

import asyncio
import time

import anyio

from homebot.cli.serve import short_collections
from homebot.control import Control
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Evidence
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from plan import Plan
from report import Report, compare
from rounds import measure_interleaved

__all__ = ["run"]

COMMANDS = 2000
LAMPS = 100
"""So many that none is switched to and fro more often than the rate limit allows."""

CONFIRMED = "confirmed"
BARE = "bare publish"
TAKEN_IN = "bare publish, report taken in"

AIM = 250
"""The most microseconds that the control layer may add to a command."""


def run(plan: Plan) -> Report:
    count = plan.count(COMMANDS)
    contenders = {
        CONFIRMED: lambda: asyncio.run(_command(count, is_controlled=True)),
        BARE: lambda: asyncio.run(_command(count, is_controlled=False)),
        TAKEN_IN: lambda: asyncio.run(_command(count, is_controlled=False, waits_for_report=True)),
    }
    with short_collections():
        samples = measure_interleaved(contenders, plan.rounds(10))
    least = {name: min(figures) * 1e6 for name, figures in samples.items()}
    note = (
        f"The control layer adds {least[CONFIRMED] - least[TAKEN_IN]:.0f} µs of CPU time to a command whose report the "
        f"house takes in (aim: less than {AIM}); against one whose report nobody takes in, "
        f"{least[CONFIRMED] - least[BARE]:.0f} µs."
    )
    return Report(
        "A command to a lamp in memory, CPU time", compare("turn on, turn off", samples, PAIRS, _text), (note,)
    )


PAIRS = ((CONFIRMED, TAKEN_IN, None), (CONFIRMED, BARE, None))


def _text(figure: float) -> str:
    return f"{figure * 1e6:.0f} µs"


async def _command(count: int, *, is_controlled: bool, waits_for_report: bool = False) -> float:
    """Return the CPU seconds of one command, to its outcome or to when the app has the lamp's report of it."""
    graph = Graph()
    async with (
        Node(graph, "memory", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "control") as control_node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        gateway = MemoryGateway(gateway_node)
        await tasks.start(gateway.serve)
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        if is_controlled:
            await tasks.start(Control(control_node).serve)
        part = simple_part("light", settable=("on_off",))
        for number in range(LAMPS):
            gateway.devices.put(GatewayDevice(f"lamp{number}", f"Lamp {number}", (part,)), "benchmark")
        devices = Devices(app)
        while len(lamps := await devices.find(Light)) < LAMPS:
            await anyio.sleep(0.01)
        spent = 0.0
        for number in range(-LAMPS, count):  # the first ones to warm up
            if number == 0:
                spent = time.process_time()
            lamp = lamps[number % LAMPS]
            was_on = lamp.on
            outcome = await (lamp.turn_off() if was_on else lamp.turn_on())
            while waits_for_report and lamp.on is was_on:
                await asyncio.sleep(0)
            assert isinstance(outcome, Confirmed)
            assert (outcome.evidence is Evidence.REPORTED) is is_controlled
        spent = time.process_time() - spent
        tasks.cancel_scope.cancel()
    return spent / count
