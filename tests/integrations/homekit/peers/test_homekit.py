"""homebot finds, pairs, reads and commands an accessory by HAP-python, an implementation that others wrote."""

import signal
import sys
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path

import anyio
import ifaddr  # noqa: F401 - it starts a program when it is imported, which must not be in the event loop
import pytest
from tests.gateways.watched_gateway import WatchedGateway
from tests.patience import PATIENCE
from tests.peers.network import Lan, Machine, Program

from homebot.devices import Sighting
from homebot.devices.gateway_messages import SendCommandResponse
from homebot.devices.value import PlainValue
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.gateways.pairing import PairResponse
from homebot.graph import Graph, Node
from homebot.integrations.homekit.gateway import HomekitGateway, HomekitGatewaySettings
from homebot.testing.gateway_contract import running

ACCESSORY = Path(__file__).with_name("accessory.py")
PIN = "031-45-154"
KEY = "12:34:56:78:9A:BC"
LAMP, LOCK = f"{KEY}.2", f"{KEY}.3"
MOST_AWAY = 5.0
"""Seconds after which homebot is back when the accessory is."""


class Home(WatchedGateway):
    """What the gateway published, and the way to command it."""

    def __init__(self, gateway: HomekitGateway, node: Node) -> None:
        self.values: dict[tuple[str, str], PlainValue] = {}
        self.devices: dict[str, Sighting] = {}
        self.gateway, self.watcher = gateway, node
        self._sightings, self._reports = self.sightings(), self.reports()

    async def found(self, key: str, *, has_parts: bool = True) -> Sighting:
        with anyio.fail_after(PATIENCE):
            while key not in self.devices or bool(self.devices[key].parts) is not has_parts:
                sighting = await self._sightings.receive()
                self.devices[sighting.key] = sighting
        return self.devices[key]

    async def until(self, key: str, capability: str, value: PlainValue, within: float = PATIENCE) -> None:
        with anyio.fail_after(within):
            while self.values.get((key, capability)) != value:
                report = await self._reports.receive()
                for one in report.readings:
                    self.values[report.key, one.capability] = one.value.plain()

    async def pair(self, code: str) -> PairResponse:
        return await self.pair_with(KEY, code)

    async def pair_for_sure(self) -> None:
        """Pair with the right code: HAP-python 5.0 loses leading zeros of SRP, and refuses one in a hundred."""
        answers = [await self.pair(PIN)]
        while not answers[-1].success and len(answers) < 4:
            answers.append(await self.pair(PIN))
        assert answers[-1].message == ""

    async def notes(self) -> str:
        return "; ".join((await self.health()).notes)

    async def send(
        self, key: str, capability: str, value: PlainValue, expires_after: float = 0.0
    ) -> SendCommandResponse:
        part = next(one.id for one in self.devices[key].parts if one.capabilities[0].name in {"on_off", "lock"})
        return await self.command(key, part, capability, value, expires_after)


@asynccontextmanager
async def home_with(hub: Machine, pairings: Path) -> AsyncIterator[Home]:
    """Run homebot's two gateways on *hub* inside the block."""
    graph = Graph()
    settings = MdnsGatewaySettings(interfaces=(hub.address,), service_types=("_hap._tcp",), announce=False)
    async with (
        Node(graph, "watcher") as node,
        Node(graph, "mdns", namespace="/gateway") as mdns_node,
        Node(graph, "homekit", namespace="/gateway") as homekit_node,
    ):
        gateway = HomekitGateway(homekit_node, HomekitGatewaySettings(pairings=pairings))
        home = Home(gateway, node)
        async with running(MdnsGateway(mdns_node, settings)), running(gateway):
            yield home


def accessory(machine: Machine, folder: Path, slowness: str = "0") -> AbstractAsyncContextManager[Program]:
    command = (
        sys.executable,
        "-P",
        str(ACCESSORY),
        machine.address,
        "51826",
        str(folder / "accessory.state"),
        slowness,
    )
    return machine.program(*command, ready="ready")


async def test_an_accessory_is_found_paired_read_commanded_and_unpaired(lan: Lan, hub: Machine, tmp_path: Path) -> None:
    device = lan.machine("device")
    async with accessory(device, tmp_path) as program, home_with(hub, tmp_path / "pairings.json") as home:
        await home.found(KEY, has_parts=False)
        assert "is not paired yet" in await home.notes()
        wrong = await home.pair("111-11-111")
        assert (wrong.success, wrong.problem) == (False, "refused")
        await home.pair_for_sure()

        lamp = await home.found(LAMP)
        assert (lamp.name, lamp.parts[0].service_type) == ("Peer lamp", "light")
        assert "id:SN-4711-42" in lamp.identifiers
        await home.until(LAMP, "on_off", False)
        for capability, value, printed in COMMANDS:
            assert (await home.send(LAMP, capability, value)).success
            await program.prints(printed)
            await home.until(LAMP, capability, value)
        assert (await home.send(LAMP, "level", 13.0)).success
        await home.until(LAMP, "on_off", True)
        await home.until(LAMP, "on_off", False)  # by the accessory itself: an event

        await home.found(LOCK)
        assert (await home.send(LOCK, "lock", "locked")).success
        await home.until(LOCK, "lock", "locking")
        await home.until(LOCK, "lock", "locked")

        assert (await home.unpair_from(KEY)).success
        await home.found(KEY, has_parts=False)
        await home.pair_for_sure()  # it is free again
        await home.until(LAMP, "reachable", True)


COMMANDS: tuple[tuple[str, PlainValue, str], ...] = (
    ("on_off", True, "lamp On 1"),
    ("level", 40.0, "lamp Brightness 40"),
    ("color", (120.0, 80.0), "lamp Hue 120"),
    ("on_off", False, "lamp On 0"),
)


async def test_an_accessory_may_be_as_slow_as_a_homebridge_with_a_plug_in_that_hangs(
    lan: Lan, hub: Machine, tmp_path: Path
) -> None:
    async with accessory(lan.machine("device"), tmp_path, "9"), home_with(hub, tmp_path / "pairings.json") as home:
        await home.found(KEY, has_parts=False)
        await home.pair_for_sure()
        await home.until(LAMP, "on_off", False)


async def test_an_accessory_of_another_controller_says_so(lan: Lan, hub: Machine, tmp_path: Path) -> None:
    device = lan.machine("device")
    async with accessory(device, tmp_path):
        async with home_with(hub, tmp_path / "other.json") as other:
            await other.found(KEY, has_parts=False)
            await other.pair_for_sure()
        async with home_with(hub, tmp_path / "pairings.json") as home:
            await home.found(KEY, has_parts=False)
            with anyio.fail_after(PATIENCE):
                while "paired with another controller" not in await home.notes():  # noqa: ASYNC110 - its news is late
                    await anyio.sleep(0.1)
            assert "another controller" in (await home.pair(PIN)).message


async def test_an_accessory_that_was_killed_is_back_soon_and_gets_no_command_twice(
    lan: Lan, hub: Machine, tmp_path: Path
) -> None:
    device = lan.machine("device")
    async with home_with(hub, tmp_path / "pairings.json") as home:
        async with accessory(device, tmp_path) as program:
            await home.found(KEY, has_parts=False)
            await home.pair_for_sure()
            await home.found(LAMP)
            await home.until(LAMP, "on_off", False)
            assert (await home.send(LAMP, "on_off", True)).success
            await program.prints("lamp On 1")
            program.end(signal.SIGKILL)
            await home.until(LAMP, "reachable", False)
            assert (await home.send(LAMP, "level", 70.0)).problem == "unreachable"
        async with accessory(device, tmp_path) as program:
            await home.until(LAMP, "reachable", True, MOST_AWAY)
            assert (await home.send(LAMP, "level", 30.0)).success
            printed = await program.prints("lamp Brightness 30")
            assert printed.count("Brightness") == 1


async def test_a_command_that_expires_on_a_dead_network_does_not_come_when_it_is_back(
    lan: Lan, hub: Machine, tmp_path: Path
) -> None:
    device = lan.machine("device")
    async with accessory(device, tmp_path) as program, home_with(hub, tmp_path / "pairings.json") as home:
        await home.found(KEY, has_parts=False)
        await home.pair_for_sure()
        await home.found(LAMP)
        await home.until(LAMP, "on_off", False)
        lan.unplug(device)
        answer = await home.send(LAMP, "level", 70.0, expires_after=1.5)
        assert (answer.success, answer.problem) == (False, "unanswered")
        lan.plug(device)
        await home.until(LAMP, "reachable", False)
        await home.until(LAMP, "reachable", True)
        assert (await home.send(LAMP, "level", 30.0)).success
        printed = await program.prints("lamp Brightness 30")
        assert "Brightness 70" not in printed


@pytest.fixture(autouse=True)
def _needs_the_libraries() -> None:
    pytest.importorskip("aiohomekit")
    pytest.importorskip("pyhap")
