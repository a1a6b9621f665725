"""Two machines and a router in networks of their own, whose link is bad and cut, and whose processes die."""

from __future__ import annotations

import itertools
import json
import re
import socket
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
import trustme
from anyio.abc import TaskGroup, TaskStatus
from tests.patience import PATIENCE
from tests.peers.network import INTERFACE, Lan, Machine, Program
from websockets.asyncio.client import ClientConnection, connect

WITHIN = 5.0
"""Seconds in which a machine that is gone is noticed, and one that is back."""

EXPIRES, SLOW = 1.0, 2.0
"""Seconds after which a command expires, from when the gateway has it, and by which a busy computer may be slow."""

BAD_LINK = ("tc", "qdisc", "add", "dev", INTERFACE, "root", "netem", "delay", "20ms", "5ms", "loss", "2%")
LAMPS = """
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway


class Lamps(MemoryGateway):
    async def serve(self, *, task_status):
        self.devices.put(GatewayDevice("lamp", "Lamp", (simple_part("light", settable=("on_off",)),)), "new")
        await self.devices.report("lamp", {"on_off": False})
        await super().serve(task_status=task_status)

    async def _perform(self, command):
        print("carried out", command.id, self.node.graph.clock.monotonic(), flush=True)
        await super()._perform(command)
"""


class House:
    """The three machines, each with its program; see :func:`house`."""

    def __init__(self, lan: Lan, folder: Path, tasks: TaskGroup) -> None:
        self.lan, self._folder, self._tasks = lan, folder, tasks
        self.router, self.first, self.attic = (lan.machine(name) for name in ("router", "first", "attic"))
        self._programs: dict[str, Program] = {}
        self._killed: dict[str, anyio.Event] = {}
        self._ended: dict[str, anyio.Event] = {}
        self.carried_out: list[str] = []
        ca = trustme.CA()
        ca.cert_pem.write_to_path(folder / "ca.pem")
        mine = ca.issue_cert(self.router.address)
        mine.private_key_pem.write_to_path(folder / "router.key")
        mine.cert_chain_pems[0].write_to_path(folder / "router.pem")
        secret = folder / "secret"
        secret.touch(0o600)
        secret.write_text("a secret of both machines\n")
        address = f"tls/{self.router.address}:7447"
        link = f'[home]\nname = "villa"\n[ros]\nconnect = ["{address}"]\nca = "ca.pem"\n'
        here = f'listen = "{address}"\ncert_file = "router.pem"\nkey_file = "router.key"\n'
        there = 'machine = "attic"\npassword_file = "secret"\n'
        files = {
            "first": f'{link}{here}[gateways.attic]\nclass = "homebot"\ntoken_file = "secret"\n',
            "attic": f'{link}{there}[gateways.lamps]\nclass = "{folder}/lamps.py:Lamps"\n',
        }
        for name, text in files.items():
            (folder / f"{name}.toml").write_text(text)
        (folder / "lamps.py").write_text(LAMPS)

    async def start(self, machine: Machine) -> None:
        """Let the program of *machine* run."""
        self._killed[machine.name], self._ended[machine.name] = anyio.Event(), anyio.Event()
        await self._tasks.start(self._run, machine)

    async def kill(self, machine: Machine) -> None:
        """End it as a power failure does."""
        self._killed[machine.name].set()
        await self._ended[machine.name].wait()

    async def _run(self, machine: Machine, *, task_status: TaskStatus[None]) -> None:
        homebot = str(Path(sys.executable).with_name("homebot"))
        verb, ready = ("router", "listening on") if machine is self.router else ("run", "is running")
        config = self._folder / ("attic.toml" if machine is self.attic else "first.toml")
        command = (homebot, verb, "--config", str(config))
        killed, ended = self._killed[machine.name], self._ended[machine.name]
        async with machine.program(*command, ready=ready) as program:
            self._programs[machine.name] = program
            task_status.started()
            await killed.wait()
        self.carried_out += re.findall(r"carried out (\S+ \S+)", "".join(program.printed))
        ended.set()

    @asynccontextmanager
    async def door(self) -> AsyncIterator[ClientConnection]:
        """Be a client of the first machine."""
        with self.first.entered():
            client = socket.create_connection(("127.0.0.1", 9090))
        owner = (self._folder / "owner.token").read_text().strip()
        header = {"Authorization": f"Bearer {owner}"}
        async with connect("ws://127.0.0.1:9090", sock=client, additional_headers=header) as connection:
            yield connection

    async def becomes(self, door: ClientConnection, state: str, within: float = WITHIN) -> None:
        """Wait until the gateway of the first machine is in *state*."""
        with anyio.move_on_after(within):
            async for frame in door:
                said = json.loads(frame)
                if said.get("topic") == "/gateway/attic/state" and said["msg"]["state"] == state:
                    return
        raise AssertionError("\n".join("".join(one.printed) for one in self._programs.values()))


@asynccontextmanager
async def running(lan: Lan, folder: Path) -> AsyncIterator[House]:
    """Run all three."""
    async with anyio.create_task_group() as tasks:
        house = House(lan, folder, tasks)
        for machine in (house.router, house.attic, house.first):
            await house.start(machine)
        yield house
        tasks.cancel_scope.cancel()


@pytest.fixture(autouse=True)
def _data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path))


async def follow(door: ClientConnection) -> None:
    await door.send(json.dumps({"op": "subscribe", "topic": "/gateway/attic/state", "type": "homebot/GatewayState"}))


async def test_who_dies_is_noticed_and_back_within_five_seconds(lan: Lan, tmp_path: Path) -> None:
    async with running(lan, tmp_path) as house:
        async with house.door() as door:
            await follow(door)
            await house.becomes(door, "active", PATIENCE)
            for machine in (house.attic, house.router):
                await house.kill(machine)
                await house.becomes(door, "unavailable")
                await house.start(machine)
                await house.becomes(door, "active")
            await house.kill(house.first)
        await house.start(house.first)
        async with house.door() as door:
            await follow(door)
            await house.becomes(door, "active")


async def test_commands_over_a_cut_link_are_carried_out_once_and_in_time(lan: Lan, tmp_path: Path) -> None:
    sent: dict[str, float] = {}

    async def command(door: ClientConnection) -> None:
        for number in itertools.count():
            name = f"c{number}"
            args = {"key": "lamp", "part": "", "capability": "on_off", "value": bool(number % 2), "id": name}
            call = {"op": "call_service", "id": name, "service": "/gateway/attic/send_command"}
            sent[name] = time.monotonic()
            await door.send(json.dumps({**call, "args": {**args, "expires_after": EXPIRES}}))
            await anyio.sleep(0.1)

    async def read(door: ClientConnection) -> None:
        async for _ in door:
            pass

    async with running(lan, tmp_path) as house:
        said = await house.attic.run(*BAD_LINK)
        assert said == "" or "qdisc kind is unknown" in said  # a kernel without netem: the link is only cut
        async with house.door() as door, house.door() as commander, anyio.create_task_group() as tasks:
            await follow(door)
            await house.becomes(door, "active", PATIENCE)
            tasks.start_soon(command, commander)
            tasks.start_soon(read, commander)
            for seconds in (0.5, 3.0, 12.0):
                await anyio.sleep(1.0)
                lan.unplug(house.attic)
                if seconds > WITHIN / 2:
                    await house.becomes(door, "unavailable")
                await anyio.sleep(seconds)
                lan.plug(house.attic)
                if seconds > WITHIN / 2:
                    await house.becomes(door, "active")
            await anyio.sleep(2.0)
            tasks.cancel_scope.cancel()
        await house.kill(house.attic)
    done = [(name, float(when)) for name, when in map(str.split, house.carried_out)]
    assert len(done) > 20
    assert len({name for name, _ in done}) == len(done), "none is carried out twice"
    assert [name for name, when in done if when > sent[name] + EXPIRES + SLOW] == [], "none is carried out late"
