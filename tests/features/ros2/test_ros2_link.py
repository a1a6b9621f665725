"""A robot on the other side of the link to ROS 2, in a running homebot with simulated devices."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import anyio
import anyio.lowlevel
import pytest
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import robot_rights

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.zenoh.current_session import CurrentSession
from homebot.bridges.zenoh.session import open_session
from homebot.config import parse_config
from homebot.devices.client_rights import ALL_RIGHTS
from homebot.devices.command_messages import CommandDevices, CommandDevicesResponse
from homebot.devices.journal_messages import ReadJournal
from homebot.devices.names import COMMAND_DEVICES, READ_JOURNAL
from homebot.devices.robot_owners import RobotOwners
from homebot.errors import UsageError
from homebot.features.ros2.link import serve_link
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import Graph, Node
from homebot.house import thesis_world
from homebot.messages.interfaces.settings import RosSettings
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime


@asynccontextmanager
async def robot_beside_house(folder: Path, *scope: str) -> AsyncIterator[tuple[Node, Node]]:
    """Yield a node of a robot whose token has *scope*, and one of the house."""
    address = f"tcp/127.0.0.1:{reserve_port()}"
    secret = folder / "rosie.token"
    secret.touch(mode=0o600)
    secret.write_text("a secret of rosie\n")
    config = parse_config(
        {
            "home": {"name": "home425"},
            "gateways": {"mqtt": {"root": "home425"}},
            "door": {"tokens": {"rosie": {"token_file": str(secret), "scope": [*scope, "robot: rosie"]}}},
            "ros": {"listen": address, "export": ["/devices/*"], "import": {"rosie": ["/rosie/**"]}},
        },
        "homebot.toml",
    )
    robot = RosSettings.model_validate({"connect": (address,), "import": {"house": ("/devices/*",)}})
    known = RobotsOnWire(robot.imports, {"house": ClientAccess("house", ALL_RIGHTS, RobotOwners())})
    graph = Graph()
    async with MemoryBroker() as broker, anyio.create_task_group() as tasks:
        services = (HostedBroker.in_memory(broker),)
        async with (
            Runtime(config, house=thesis_world(), with_door=False, services=services) as runtime,
            Node(runtime.graph, "tester") as tester,
            open_session(robot, robot_rights(robot, "rosie")) as session,
            Node(graph, "ros2") as node,
            Node(graph, "nav") as nav,
        ):
            node.create_task(session.run)
            await tasks.start(partial(serve_link, node, session, robot, known))
            yield nav, tester
            tasks.cancel_scope.cancel()


async def commanded(nav: Node) -> CommandDevicesResponse:
    """Switch the lights on, once they are known; the robot pretends to be an app with every right."""
    client = nav.create_client(CommandDevices, COMMAND_DEVICES)
    assert await client.wait_for_service(PATIENCE)
    request = CommandDevices.Request(target="light", command="on", issuer="/an_app", scope=("act: all",))
    with anyio.fail_after(PATIENCE):
        while (answer := await client.call(request, PATIENCE)).message.startswith("no device"):
            await anyio.lowlevel.checkpoint()
    return answer


async def test_a_robot_commands_devices_as_itself(tmp_path: Path) -> None:
    async with robot_beside_house(tmp_path, "read", "act: light") as (nav, tester):
        answer = await commanded(nav)
        assert answer.success, answer.message
        journal = await tester.create_client(ReadJournal, READ_JOURNAL).call(ReadJournal.Request(), PATIENCE)
        issuers = {entry.issuer for entry in journal.entries if entry.kind == "requested"}
        assert issuers == {"client:rosie"}


@pytest.mark.parametrize(
    ("scope", "reason"),
    [(("read",), "the right act is missing; the token rosie has"), (("read", "act: lock"), "rights")],
)
async def test_a_robot_without_the_right_commands_nothing(tmp_path: Path, scope: tuple[str, ...], reason: str) -> None:
    async with robot_beside_house(tmp_path, *scope) as (nav, tester):
        answer = await commanded(nav)
        assert not answer.success
        assert reason in f"{answer.message} {[one.result.policy for one in answer.results]}"
        journal = await tester.create_client(ReadJournal, READ_JOURNAL).call(ReadJournal.Request(), PATIENCE)
        assert "sent" not in {entry.kind for entry in journal.entries}


async def test_a_robot_without_a_token_stops_the_start_and_leaves_no_session() -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    ros = {"listen": address, "import": {"rosie": ["/rosie/**"]}}
    runtime = Runtime(parse_config({"ros": ros}, "homebot.toml"), with_door=False)
    with pytest.raises(UsageError, match=r"\[ros\] import: no token has the right 'robot: rosie'"):
        async with runtime:
            pytest.fail("it must not start")
    current = runtime.service(CurrentSession)
    assert current is not None
    assert current.session is None
