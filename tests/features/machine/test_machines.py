"""Two homebots as two machines of one house: one has a simulated house, the other the index and the control of it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import anyio.lowlevel
import pytest
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.bridges.rosapi.doctor import Examine
from homebot.config import Config, parse_config
from homebot.devices import DEVICE_CHANGES, Device, DeviceChange
from homebot.devices.command_messages import CommandDevices, CommandDevicesResponse
from homebot.devices.journal_messages import ReadJournal
from homebot.devices.names import COMMAND_DEVICES, READ_JOURNAL
from homebot.graph import Node, Subscription
from homebot.house import thesis_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime

pytestmark = pytest.mark.rooms("machine")

LAMP = "lights/philips165"


class Machines:
    """The configurations of both machines, which may run or not."""

    def __init__(self, folder: Path) -> None:
        secret = folder / "attic.token"
        secret.touch(mode=0o600)
        secret.write_text("a secret of both machines\n")
        address, home = f"tcp/127.0.0.1:{reserve_port()}", {"name": "villa"}
        attic = {"class": "homebot", "token_file": str(secret)}
        first = {"home": home, "gateways": {"attic": attic}, "ros": {"listen": address}}
        link = {"connect": [address], "machine": "attic", "password_file": str(secret)}
        # the table `cellar` would go round: what is of another machine is not exported
        cellar = {"class": "homebot", "machine": "attic", "gateway": "mqtt", "token_file": str(secret)}
        second = {"home": home, "gateways": {"mqtt": {"root": "home425"}, "cellar": cellar}, "ros": link}
        self.first, self.second = parse_config(first, "first.toml"), parse_config(second, "second.toml")

    @asynccontextmanager
    async def running_first(self) -> AsyncIterator[Node]:
        """Run the machine with the index; yield a node of it."""
        async with _running(self.first) as runtime, Node(runtime.graph, "tester") as tester:
            yield tester

    @asynccontextmanager
    async def running_second(self) -> AsyncIterator[Runtime]:
        """Run the machine with the devices."""
        async with MemoryBroker() as broker:
            services = (HostedBroker.in_memory(broker),)
            async with Runtime(self.second, house=thesis_world(), with_door=False, services=services) as runtime:
                yield runtime


def _running(config: Config) -> Runtime:
    return Runtime(config, with_door=False, trusts_apps=True)


@pytest.fixture
def machines(tmp_path: Path) -> Machines:
    return Machines(tmp_path)


def changes_of(tester: Node) -> Subscription[DeviceChange]:
    return tester.create_subscription(DeviceChange, DEVICE_CHANGES, qos_profile=100)


async def becomes(changes: Subscription[DeviceChange], *, reachable: bool) -> Device:
    """Wait until the lamp is reachable or not."""
    with anyio.fail_after(PATIENCE):
        async for change in changes:
            if change.device.id == LAMP and (change.device.reachable.state != "no") is reachable:
                return change.device
    raise AssertionError("the changes ended")


async def commanded(tester: Node, command: str) -> CommandDevicesResponse:
    request = CommandDevices.Request(target=LAMP, command=command, issuer="/an_app", scope=("act: all",))
    client = tester.create_client(CommandDevices, COMMAND_DEVICES)
    with anyio.fail_after(PATIENCE):
        while (answer := await client.call(request, PATIENCE)).message.startswith("no device"):
            await anyio.lowlevel.checkpoint()
    return answer


async def test_a_lamp_of_the_other_machine_obeys_and_the_journal_here_has_it(machines: Machines) -> None:
    async with machines.running_first() as tester, machines.running_second():
        answer = await commanded(tester, "on")
        assert (answer.success, answer.outcome) == (True, "confirmed")
        entries = (await tester.create_client(ReadJournal, READ_JOURNAL).call(ReadJournal.Request())).entries
        assert {one.device for one in entries} == {LAMP}


async def test_devices_are_unreachable_while_their_machine_is_away_and_commands_are_not_sent(
    machines: Machines,
) -> None:
    async with machines.running_first() as tester:
        changes = changes_of(tester)
        async with machines.running_second():
            await becomes(changes, reachable=True)
        lost = await becomes(changes, reachable=False)
        assert "attic is unavailable: its machine does not answer" in lost.reachable.why
        answer = await commanded(tester, "on")
        assert (
            answer.results[0].result.text == "not sent: on_off of lights/philips165: its machine does not answer; "
            "is homebot running there, with this name and home, in the same version?"
        )
        async with machines.running_second():
            await becomes(changes, reachable=True)


@pytest.mark.rooms("ros2")
async def test_the_other_machine_tells_its_user_what_it_is_and_whether_the_house_lets_it_in(machines: Machines) -> None:
    async with machines.running_second() as second, Node(second.graph, "tester") as tester:
        doctor = tester.create_client(Examine, "/rosapi/doctor")
        assert await doctor.wait_for_service(PATIENCE)

        async def troubles() -> str:
            return str((await doctor.call(Examine.Request(), PATIENCE)).findings)

        assert "lets it in: does it run, and does it know the login?" in await troubles()
        async with machines.running_first():
            with anyio.fail_after(PATIENCE):
                while "lets it in" in await troubles() or "follows mqtt" in await troubles():
                    await anyio.lowlevel.checkpoint()


async def test_the_other_machine_has_neither_index_nor_control_and_exports_its_own_gateways_alone(
    machines: Machines,
) -> None:
    async with machines.running_first() as tester, machines.running_second() as second:
        await commanded(tester, "on")
        there = set(second.graph.get_node_names())
        assert {"/gateway/mqtt", "/gateway/cellar", "/machine"} <= there
        assert not {"/discovery", "/control", "/alerts", "/history", "/robots"} & there
        names = {name for name in tester.graph.get_service_names_and_types() if name.startswith("/villa/")}
        assert not names, "what machines say to each other is not on the graph"
