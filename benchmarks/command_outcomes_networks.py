"""Commands to devices with faults over real networks: a real Mosquitto, and every gateway that drives devices itself.

The table of ``command_outcomes.py`` for each transport, in real time: MQTT over a Mosquitto process, and the servers of
each other protocol on loopback or on a virtual radio. All lamps get their commands side by side.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.command_messages import CommandEvent
from homebot.devices.handles import Light
from homebot.devices.names import COMMAND_EVENTS
from homebot.graph import Graph, Node
from homebot.house import SimulatedHouse, World
from homebot.house.description import parse_world
from homebot.house.devices import SimulatedLamp
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.family import dialects
from homebot.house.faults import unwrap
from homebot.house.wire import hardware_address
from homebot.runtime import Runtime
from homebot.support.toml_file import parse_toml

sys.path.append(str(Path(__file__).parents[1]))
from tests.simulated.ble_family import LIGHT_PROFILE
from tests.simulated.families import FAMILIES, families_with

from mosquitto import mosquitto
from outcome_counts import FAULTS, HEADINGS, OutcomeCount, row
from plan import Plan
from report import Report

__all__ = ["run"]

COMMANDS = 20
GAP = 21.0
"""Seconds between two commands to a lamp: the limit for its answer, and the time in which it may go back."""

STRIDE = 0.05  # seconds between the first commands to two lamps
FIND_WITHIN = 60.0
MOSQUITTO = "MQTT, Mosquitto"
FOUND_AS_PLUGS = frozenset({"matter_plug"})
ROOT = "home425"


@dataclass(frozen=True, slots=True)
class Case:
    """A kind of lamp: its transport, its fault, and whether its commands are forgotten."""

    transport: str
    fault: str
    forgets: bool


class Lamps:
    """The lamps of a world, one for each dialect, fault and way of commanding it. Radios take only short names.

    Args:
        transports: The names of the transports, by the dialects of devices on them.
    """

    def __init__(self, transports: Mapping[str, str]) -> None:
        self.cases: dict[str, Case] = {}
        tables = ["rooms.hall = {}"]
        for dialect, transport in transports.items():
            for fault, settings in FAULTS.items():
                for forgets in (True, False):
                    name = f"l{len(self.cases):03}"
                    self.cases[name] = Case(transport, fault, forgets)
                    tables.append(
                        f'devices.{name} = {{ kind = "lamp", room = "hall", dialect = "{dialect}", '
                        f"faults = {{ {settings} }} }}"
                    )
        self.world = parse_world(parse_toml("\n".join(tables), "benchmark"), "benchmark")
        self.counts = {case: OutcomeCount() for case in self.cases.values()}

    def real(self, name: str) -> SimulatedLamp:
        real = unwrap(self.world.devices[name].device)
        assert isinstance(real, SimulatedLamp)
        return real


def run(plan: Plan) -> Report:
    count = plan.count(COMMANDS)
    counts: dict[Case, OutcomeCount] = {}
    notes = ["In real time. The devices run in the same process as homebot, with clients and servers of their own."]
    missing = []
    if plan.mosquitto is None:
        missing.append("MQTT, as Mosquitto is not installed")
    else:
        with mosquitto(plan.mosquitto) as port:
            lamps = Lamps(dict.fromkeys(sorted(dialects()), MOSQUITTO))
            asyncio.run(_measure(lamps, _on_mosquitto(f"mqtt://127.0.0.1:{port}", lamps.world), count))
        counts |= lamps.counts
    lamps = Lamps({FAMILIES[name]: name for name in families_with("lamp") if name not in FOUND_AS_PLUGS})
    asyncio.run(_measure(lamps, _on_own_networks(lamps.world), count))
    counts |= lamps.counts
    rows: list[tuple[str, ...]] = [("transport", *HEADINGS)]
    for transport in dict.fromkeys(case.transport for case in counts):
        for fault in FAULTS:
            forgotten, told = (counts[Case(transport, fault, forgets)] for forgets in (True, False))
            rows.append((transport, *row(fault, forgotten, told)))
    return Report("Commands to devices with faults, over each network", (), tuple(notes), rows, missing)


@asynccontextmanager
async def _on_mosquitto(url: str, world: World) -> AsyncIterator[Graph]:
    tables = {"gateways": {"mqtt": {"url": url, "act": True, "root": ROOT}}, "discovery": {"persist": False}}
    async with Runtime(parse_config(tables, "benchmark"), with_door=False, trusts_apps=True) as runtime:
        house = SimulatedHouse(url, ROOT, world, runtime.graph.clock)
        async with anyio.create_task_group() as tasks:
            await tasks.start(house.serve)
            yield runtime.graph
            tasks.cancel_scope.cancel()


@asynccontextmanager
async def _on_own_networks(world: World) -> AsyncIterator[Graph]:
    ble = {"max_connections": 50, "profiles": {"light": LIGHT_PROFILE}}
    tables = {"gateways": {"mqtt": {"root": ROOT}, "ble": ble}, "discovery": {"persist": False}}
    config = parse_config(tables, "benchmark")
    async with Runtime(config, house=world, with_door=False) as runtime:
        yield runtime.graph


async def _measure(lamps: Lamps, graph_of: AbstractAsyncContextManager[Graph], count: int) -> None:
    reverted: dict[str, float] = {}

    def note_event(event: CommandEvent) -> None:
        reverted[event.result.command_id] = anyio.current_time()

    async with graph_of as graph, Node(graph, "app") as node:
        node.create_subscription(CommandEvent, COMMAND_EVENTS, note_event, 1000)
        devices = Devices(node)
        handles = await _found(devices, lamps.cases.keys())
        async with anyio.create_task_group() as tasks:
            for number, (name, case) in enumerate(lamps.cases.items()):
                tasks.start_soon(
                    _command,
                    devices,
                    handles[name],
                    lamps.real(name),
                    case,
                    lamps.counts[case],
                    reverted,
                    count,
                    number,
                )


async def _found(devices: Devices, names: Iterable[str]) -> dict[str, Light]:
    """Return the handles of all lamps, as soon as they are known, by the names that the house has for them."""
    shown = {name: name for name in names}  # by how the device calls itself: by its name, or by its hardware address
    shown |= {hardware_address(SimulatedDeviceInfo(ROOT, "lamp", name, "lights", "hall")): name for name in shown}
    with anyio.fail_after(FIND_WITHIN):
        while True:
            lights = {shown.get(one.name.rpartition("-")[2].lower(), ""): one for one in await devices.find(Light)}
            if len(lights.keys() & shown.keys()) == len(shown) // 2:
                return lights
            await anyio.sleep(0.5)


async def _command(
    devices: Devices,
    light: Light,
    real: SimulatedLamp,
    case: Case,
    found: OutcomeCount,
    reverted: dict[str, float],
    count: int,
    number: int,
) -> None:
    await anyio.sleep(number * STRIDE)
    for turn in range(count):
        wanted = turn % 2 == 0
        began = anyio.current_time()
        outcome = None
        if case.forgets:
            await devices.tell(light.device, "on" if wanted else "off")
        else:
            outcome = await (light.turn_on() if wanted else light.turn_off())
        ended = anyio.current_time()
        await anyio.sleep(max(0.0, began + GAP - ended))
        reverted_at = None if outcome is None else reverted.get(outcome.command_id)
        found.note(outcome, began, ended, reverted_at, obeyed=real.is_on is wanted)
