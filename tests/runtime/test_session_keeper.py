"""The rights of robots on Zenoh change as the configuration of a running homebot does."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue

import anyio
import anyio.lowlevel
import pytest
import zenoh
from anyio import to_thread
from structlog.testing import capture_logs
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import log_in, write_tokens

from homebot.bridges.zenoh.current_session import CurrentSession
from homebot.config import Config, parse_config
from homebot.devices.client_rights import OWNER_CLIENT
from homebot.devices.health import GetHealth
from homebot.graph import Graph, Node
from homebot.house import World, thesis_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan
from homebot.runtime.session_keeper import SessionKeeper
from homebot.support.toml_file import parse_toml

pytestmark = pytest.mark.rooms("ros2")

ROBOTS = '{rosie = ["/rosie/**"], bob = ["/bob/**"]}'


class House:
    """A homebot that is a router, and its configuration."""

    def __init__(self, folder: Path) -> None:
        self.address = f"tcp/127.0.0.1:{reserve_port()}"
        self._folder = folder
        write_tokens(folder, "rosie", "bob")

    def config(self, *robots: str, imports: str = ROBOTS, ros: str = "") -> Config:
        """Return the configuration with the tokens of *robots*."""
        ros = f'[ros]\nlisten = "{self.address}"\nimport = {imports}\n{ros}'
        tokens = "".join(
            f'[door.tokens.{one}]\ntoken_file = "{one}.token"\nscope = ["read", "robot: {one}"]\n' for one in robots
        )
        text = f'[home]\nname = "villa"\n{tokens}{ros}'
        return parse_config(parse_toml(text, "homebot.toml"), "homebot.toml", self._folder)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[Runtime]:
        async with Runtime(self.config("rosie", "bob"), with_door=False) as runtime:
            yield runtime

    async def node_seen_by(self, robot: str) -> str:
        """Return the token of homebot's node, as *robot* sees it once it is there."""

        def look() -> str:
            for _ in range(int(PATIENCE)):
                with (
                    suppress(zenoh.ZError),
                    log_in(self.address, robot, patience=3.0) as session,
                ):  # while the router begins again
                    for token in _nodes(session):
                        if token.endswith("/ros2"):
                            return token
            raise TimeoutError

        return await to_thread.run_sync(look)

    async def has_begun_again(self, before: str) -> None:
        """Wait until bob sees another node than *before*."""
        with anyio.fail_after(PATIENCE):
            while await self.node_seen_by("bob") == before:
                await anyio.lowlevel.checkpoint()


def _nodes(session: zenoh.Session) -> Iterator[str]:
    """Yield the tokens of nodes that come within a second: a query whose router leaves may never end."""
    found = SimpleQueue[str]()
    session.liveliness().get(
        "@ros2_lv/0/*/*/*/NN/**",
        lambda reply: found.put("" if reply.ok is None else str(reply.ok.key_expr)),
        timeout=1.0,
    )
    with suppress(Empty):
        while True:
            yield found.get(timeout=1.0)


@pytest.fixture
def house(tmp_path: Path) -> House:
    return House(tmp_path)


async def test_a_robot_whose_token_was_revoked_is_shut_out_and_others_stay(house: House) -> None:
    async with house.running() as runtime:
        before = await house.node_seen_by("rosie")
        answer = await runtime.reload(lambda: house.config("bob"))
        assert answer.success, answer.message
        assert "restart" not in answer.message
        await house.has_begun_again(before)
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            await to_thread.run_sync(log_in, house.address, "rosie")
        async with Node(runtime.graph, "doctor") as node:
            health = await node.create_client(GetHealth, "/ros2/health").call(GetHealth.Request(), PATIENCE)
        assert "nothing is taken from rosie: no token has the right 'robot: rosie' now" in str(health.troubles)


async def test_a_reload_that_changes_no_right_of_robots_leaves_their_link_alone(house: House) -> None:
    async with house.running() as runtime:
        before = await house.node_seen_by("rosie")
        answer = await runtime.reload(lambda: house.config("rosie", "bob"))
        assert answer.success
        assert await house.node_seen_by("rosie") == before
        await runtime.reload(lambda: house.config("rosie", "bob", ros='export = ["/map"]\n'))
        await house.has_begun_again(before)


async def test_a_name_of_two_robots_is_refused_and_nothing_changes(house: House) -> None:
    async with house.running() as runtime:
        before = await house.node_seen_by("rosie")
        both = '{rosie = ["/tf"], bob = ["/tf"]}'
        with capture_logs():
            answer = await runtime.reload(lambda: house.config("rosie", "bob", imports=both))
        assert "homebot.toml: ros.import: /tf of rosie and /tf of bob have names in common" in answer.message
        assert await house.node_seen_by("rosie") == before


async def test_a_link_that_cannot_be_opened_again_is_told_and_comes_back_with_a_better_configuration(
    house: House,
) -> None:
    async with house.running() as runtime:
        await house.node_seen_by("rosie")
        missing = 'cert_file = "router.crt"\nkey_file = "router.key"\n'
        with capture_logs() as lines:
            await runtime.reload(lambda: house.config("rosie", "bob", ros=missing))
            with anyio.fail_after(PATIENCE):
                while not any(line["event"] == "ros2.not_linked" for line in lines):
                    await anyio.lowlevel.checkpoint()
        assert any("router.crt: No such file" in str(line.get("message")) for line in lines)
        await runtime.reload(lambda: house.config("rosie", "bob"))
        await house.node_seen_by("rosie")


async def test_a_robot_is_shut_out_when_its_token_ends(house: House) -> None:
    plan, graph = make_plan(house.config("rosie", "bob")), Graph()
    ending = plan.door.tokens["rosie"].model_copy(update={"until": graph.clock.now() + 1.5})
    door = plan.door.model_copy(update={"tokens": {**plan.door.tokens, "rosie": ending}})
    plan = replace(plan, door=door)
    async with anyio.create_task_group() as tasks:
        starter = SessionKeeper(graph, CurrentSession(), lambda: plan, nobody)
        await tasks.start(starter.serve)
        before = await house.node_seen_by("rosie")
        await house.has_begun_again(before)
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            await to_thread.run_sync(log_in, house.address, "rosie")
        tasks.cancel_scope.cancel()


async def test_the_link_begins_again_after_a_panic_inside_zenoh(house: House) -> None:
    """Each later answer panicked, too, as locks inside the session were of no use any more."""
    plan, current = make_plan(house.config("rosie", "bob")), CurrentSession()
    async with anyio.create_task_group() as tasks:
        starter = SessionKeeper(Graph(), current, lambda: plan, nobody)
        await tasks.start(starter.serve)
        before = await house.node_seen_by("rosie")
        assert current.session is not None
        with capture_logs() as lines:
            current.session.panicked.set()
            await house.has_begun_again(before)
        assert "ros2.panicked" in [line["event"] for line in lines]
        tasks.cancel_scope.cancel()


async def nobody() -> None:
    """There is no token of an owner."""


@pytest.mark.parametrize("simulated", [None, thesis_world()], ids=["a real home", "a simulated house"])
async def test_the_owner_logs_in_at_a_home_and_at_a_simulated_house(
    house: House, tmp_path: Path, simulated: World | None
) -> None:
    config = house.config("rosie", "bob").model_copy(update={"gateways": {"mqtt": {}}})
    owner = tmp_path / "owner.token"
    async with (
        MemoryBroker() as broker,
        Runtime(
            config,
            house=simulated,
            services=(HostedBroker.in_memory(broker),),
            owner_file=owner,
            with_door=False,
        ),
    ):
        secret = owner.read_text().strip()
        with await to_thread.run_sync(partial(log_in, house.address, OWNER_CLIENT, secret, patience=PATIENCE)):
            pass


async def test_a_dry_run_says_that_it_has_no_link(house: House) -> None:
    config = house.config("rosie", "bob").model_copy(update={"door": {"port": 0}})
    with capture_logs() as lines:
        async with Runtime(config, is_dry_run=True):
            pass
    assert "no link of [ros]" in str([line["message"] for line in lines if line["event"] == "runtime.running"])
