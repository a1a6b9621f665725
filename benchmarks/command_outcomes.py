"""Commands to devices with faults: how often one fails and nobody is told; in a simulated house, in virtual time.

The same commands are given to the same lamps twice: fire and forget, as most programs do, and through handles, whose
outcome is held against what the lamp did. A failure is silent where the outcome, or what was reported of it within the
settle time, says that the lamp obeyed and it did not. The metering plug and the light sensor beside some lamps are
named as their witnesses.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from tempfile import TemporaryDirectory

import anyio

from homebot.devices import Devices
from homebot.devices.command_messages import CommandEvent
from homebot.devices.handles import Light
from homebot.devices.names import COMMAND_EVENTS
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import load_world
from homebot.house.devices import SimulatedLamp
from homebot.house.family import dialects
from homebot.house.faults import unwrap
from homebot.testing import VirtualTimeLoop, virtual_house_of
from outcome_counts import FAULTS, HEADINGS, OutcomeCount, row
from plan import Plan
from report import Report

__all__ = ["run"]

COMMANDS = 20
GAP = 40.0  # seconds between two commands to a lamp
NAMES = ("plug", "lux")
"""The second devices, as the owner names them for witnesses."""

OFTEN, SELDOM = 2.0, 300.0  # seconds between two reports of the same
WITNESSES = {
    "metering plug": 'devices.plug = { kind = "power_meter", room = "hall", dialect = "zigbee2mqtt", of = "lamp" }',
    "light sensor": 'devices.lux = { kind = "lux", room = "hall", dialect = "zigbee2mqtt" }',
}
SEEN_FAULTS = {
    "none": "",
    "slow": FAULTS["slow, 5 to 7.5 s"],
    "liar": f"liar = {{ since = {60.0 - 0.5 * GAP} }}",
}
WITNESSED = {
    f"{fault}, {witness}": (settings, device)
    for witness, device in WITNESSES.items()
    for fault, settings in SEEN_FAULTS.items()
}


def run(plan: Plan) -> Report:
    rows: list[tuple[str, ...]] = [HEADINGS]
    for fault, (settings, witness) in ({one: (text, "") for one, text in FAULTS.items()} | WITNESSED).items():
        forgotten, told = OutcomeCount(), OutcomeCount()
        for dialect in sorted(dialects()):
            for found, forgets in ((forgotten, True), (told, False)):
                world, count = _world(dialect, settings, witness), plan.count(COMMANDS)
                name = next((one for one in NAMES if f"devices.{one} " in witness), "")
                with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
                    runner.run(_measure(world, count, found, name, forgets=forgets))
        rows.append(row(fault, forgotten, told))
    lamps = (
        f"A lamp of each dialect: {', '.join(dialects())}. Where no second device sees it, a liar is believed and"
        " graded reported."
    )
    return Report("Commands to devices with faults", (), (lamps,), rows)


def _world(dialect: str, fault: str, more: str) -> World:
    lamp = f'devices.lamp = {{ kind = "lamp", room = "hall", dialect = "{dialect}", faults = {{ {fault} }} }}'
    with TemporaryDirectory() as folder:
        file = Path(folder) / "house.toml"
        file.write_text(f"rooms.hall = {{}}\n{lamp}\n{more}\n")
        return load_world(file)


async def _measure(world: World, count: int, found: OutcomeCount, witness: str, *, forgets: bool) -> None:
    real = unwrap(world.devices["lamp"].device)
    assert isinstance(real, SimulatedLamp)
    reverted: dict[str, float] = {}

    def note_event(event: CommandEvent) -> None:
        reverted[event.result.command_id] = anyio.current_time()

    heartbeat = OFTEN if witness else SELDOM  # a silent sensor is no witness
    config = {"control": {"witnesses": {"light": witness}}} if witness else None
    async with (
        virtual_house_of(world=world, heartbeat=heartbeat, config=config) as house,
        Node(house.runtime.graph, "app") as node,
    ):
        node.create_subscription(CommandEvent, COMMAND_EVENTS, note_event, 1000)
        devices = Devices(node)
        await anyio.sleep(60)
        (lamp,) = await devices.find(Light)
        for number in range(count):
            wanted = number % 2 == 0
            began = anyio.current_time()
            outcome = None if forgets else await (lamp.turn_on() if wanted else lamp.turn_off())
            if forgets:
                await devices.tell(lamp.device, "on" if wanted else "off")
            ended = anyio.current_time()
            await anyio.sleep(began + GAP - ended)
            reverted_at = None if outcome is None else reverted.get(outcome.command_id)
            found.note(outcome, began, ended, reverted_at, obeyed=real.is_on is wanted)
