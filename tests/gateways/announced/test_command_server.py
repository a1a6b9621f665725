"""Commands and raw commands of one gateway keep their order; in virtual time."""

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import Any

import anyio
import anyio.lowlevel
import pytest

from homebot.devices import RawCommand
from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.names import text_address
from homebot.devices.part import CommandDescription
from homebot.devices.value import Value
from homebot.errors import LinkError, ServiceFailedError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Graph, Node, Publisher
from homebot.support.unanswered import awaiting_answer

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

AT_WORK = 1000
"""Raw commands that a gateway sends at once; as many more wait."""


class SlowGateway(MemoryGateway):
    """A gateway whose network takes ten seconds for each command."""

    def begin(self) -> None:
        self.begun: list[str] = []
        self.ended: list[str] = []
        self.patience = 100.0
        self.answer_limit = math.inf

    async def _perform(self, command: Command) -> None:
        self.begun.append(command.id)
        if self.answer_limit < math.inf:
            with awaiting_answer():
                await anyio.sleep(self.answer_limit)
                raise LinkError("no answer")
        with anyio.fail_after(self.patience):
            await anyio.sleep(10)
        self.ended.append(command.id)


class House:
    def __init__(self, gateway: SlowGateway, out: Publisher[RawCommand], app: Node) -> None:
        self.gateway = gateway
        self._out = out
        self._send = app.create_client(SendCommand, gateway.names.send_command)

    def say(self, count: int, **more: Any) -> list[str]:
        """Publish so many texts; return their ids."""
        ids = [f"text {number}" for number in range(count)]
        for one in ids:
            self._out.publish(RawCommand(address=text_address("lamp", ""), payload="on", command_id=one, **more))
        return ids

    async def command(self, expires_after: float = 0.0, **more: Any) -> SendCommandResponse:
        command = Command(
            key="lamp",
            part="",
            capability="on_off",
            value=Value.of(False),
            id="command",
            expires_after=expires_after,
            **more,
        )
        return await self._send.call(command, timeout=100)


@asynccontextmanager
async def house() -> AsyncIterator[House]:
    graph = Graph()
    async with (
        Node(graph, "memory", namespace="/gateway") as node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        gateway = SlowGateway(node, MemoryGatewaySettings(act=True))
        gateway.begin()
        await tasks.start(gateway.serve)
        gateway.devices.put(GatewayDevice("lamp", "Lamp", (simple_part("light", settable=("on_off",)),)), "a test")
        yield House(gateway, app.create_publisher(RawCommand, gateway.names.out, 10_000), app)
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("count", [0, 1, 300])
async def test_a_command_is_sent_after_the_texts_before_it(count: int) -> None:
    async with house() as home:
        ids = home.say(count)
        assert (await home.command()).success
        assert home.gateway.begun == [*ids, "command"]


@pytest.mark.parametrize("turns", range(6))
@pytest.mark.parametrize("count", [1, 2, 3])
async def test_so_it_is_in_whichever_turn_of_the_loop_it_comes(count: int, turns: int) -> None:
    """A random day found it: texts that were taken, and not begun yet, were overtaken."""
    async with house() as home:
        ids = home.say(count)
        for _ in range(turns):
            await anyio.lowlevel.checkpoint()
        assert (await home.command()).success
        assert home.gateway.begun == [*ids, "command"]


async def test_it_waits_for_no_text_to_end() -> None:
    async with house() as home:
        home.say(5)
        with anyio.fail_after(11):
            await home.command(expires_after=10.5)


async def test_where_texts_pile_up_a_command_keeps_its_turn() -> None:
    """A text is begun there only when another one has ended."""
    async with house() as home:
        ids = home.say(AT_WORK)
        await anyio.sleep(1)
        ids += home.say(5)
        with anyio.fail_after(21):
            assert (await home.command()).success
        assert home.gateway.begun == [*ids, "command"]


async def test_a_command_that_expires_meanwhile_is_not_sent() -> None:
    async with house() as home:
        home.say(AT_WORK)
        await anyio.sleep(1)
        home.say(5)
        answer = await home.command(expires_after=2.0)
        assert (answer.success, answer.problem) == (False, "unreachable")
        await anyio.sleep(30)
        assert "command" not in home.gateway.begun


async def test_a_command_that_expires_at_work_is_given_up() -> None:
    async with house() as home:
        answer = await home.command(expires_after=2.0)
        assert (answer.problem, answer.message) == ("unreachable", "lamp was not reached within 2 s")
        await anyio.sleep(30)
        assert (home.gateway.begun, home.gateway.ended) == (["command"], [])
        assert (await home.command(expires_after=10.5)).success


@pytest.mark.parametrize("answer_limit", [1.0, 10.0])
async def test_a_command_that_was_sent_and_not_acknowledged_is_unanswered(answer_limit: float) -> None:
    """It may arrive later: it was given up by the limit of the port, or by its own."""
    async with house() as home:
        home.gateway.answer_limit = answer_limit
        assert (await home.command(expires_after=5.0)).problem == "unanswered"


async def test_a_time_limit_of_the_gateway_itself_is_no_expiry() -> None:
    async with house() as home:
        home.gateway.patience = 1.0
        with pytest.raises(ServiceFailedError, match="TimeoutError"):
            await home.command(expires_after=2.0)


async def test_texts_that_were_dropped_hold_up_no_command() -> None:
    async with house() as home:
        home.say(AT_WORK)
        await anyio.sleep(1)
        home.say(AT_WORK + 5)
        with anyio.fail_after(21):
            assert (await home.command()).success
        assert home.gateway.begun[-1] == "command"
        assert len(home.gateway.begun) == 2 * AT_WORK + 1


def lamp(topic: str, payloads: str = "") -> GatewayDevice:
    part = simple_part("light", settable=("on_off",)).model_copy(update={"writes": (topic,), "payloads": payloads})
    return GatewayDevice("lamp", "Lamp", (part,))


APPROVED = CommandDescription.of(lamp("lamp/set").parts[0], ()).digest


@pytest.mark.parametrize("is_text", [False, True])
@pytest.mark.parametrize("waiting", [0, 5])
@pytest.mark.parametrize(
    ("known", "now"),
    [
        ({"topics": ("lamp/set",)}, lamp("door/set")),
        ({"topics": ("lamp/set",), "approved": APPROVED}, lamp("lamp/set", "others")),
    ],
)
async def test_a_part_that_is_announced_anew_gets_no_command_that_was_checked_before(
    known: dict[str, Any], waiting: int, now: GatewayDevice, *, is_text: bool
) -> None:
    """Its new topics were not compared with those of others yet, nor its payloads approved."""
    async with house() as home:
        home.gateway.devices.put(lamp("lamp/set"), "a test")
        ids = home.say(waiting)
        async with anyio.create_task_group() as tasks:
            if is_text:
                home.say(1, **known)
            else:
                tasks.start_soon(partial(home.command, **known))
            home.gateway.devices.put(now, "a test")
        await anyio.sleep(30)
        assert home.gateway.begun == ids
