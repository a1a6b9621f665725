"""How soon a link is found out that carries nothing any more."""

from collections.abc import Callable

import anyio
import pytest
from anyio.abc import SocketAttribute, SocketStream
from hypothesis import given
from hypothesis import strategies as st
from tests.mqtt.client.scripted_broker import MakeClient, Peer, broker
from tests.patience import PATIENCE
from tests.turns import Lateness

from homebot.errors import LinkError
from homebot.mqtt.broker import Broker
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.client.keep_alive import KeepAlive, LifeSign
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.slow


def silence(interval: float, timeout: float, heard: list[float], answers: Callable[[float], bool]) -> tuple[float, int]:
    """How long after the last sign of life the link is given up, and how many pings there were."""
    keep_alive = KeepAlive(interval, timeout, 0.0)
    coming = sorted(heard)
    last, pings = 0.0, 0
    while True:
        while coming and coming[0] <= keep_alive.due:
            last = coming.pop(0)
            keep_alive.heard_at = last
        now = keep_alive.due
        match keep_alive.check(now):
            case LifeSign.LOST:
                return now - last, pings
            case LifeSign.PING:
                pings += 1
                if answers(now):
                    last = now
                    keep_alive.heard_at = now
            case LifeSign.WAIT:
                pass


@given(
    st.floats(5, 100),
    st.floats(0.1, 100),
    st.lists(st.floats(0, 1000), max_size=30),
    st.floats(0, 1000),
)
def test_a_dead_link_is_found_out_after_one_and_a_half_intervals_whatever_came_before(
    interval: float, timeout: float, heard: list[float], dies: float
) -> None:
    before = [each for each in heard if each <= dies]
    took, _ = silence(interval, timeout, before, lambda now: now <= dies)
    assert took <= 1.5 * interval * 1.0001


def test_a_link_that_answers_is_kept_with_one_ping_an_interval() -> None:
    took, pings = silence(30, 10, [], lambda now: now < 3600)
    assert took == pytest.approx(40)
    assert pings == 120


def test_hearing_something_is_as_good_as_an_answer() -> None:
    keep_alive = KeepAlive(30, 10, 0.0)
    assert keep_alive.check(30.0) is LifeSign.PING
    keep_alive.heard_at = 35.0
    assert keep_alive.check(40.0) is LifeSign.WAIT


def test_a_client_that_hears_all_the_time_pings_all_the_same() -> None:
    """The broker would take it for dead."""
    keep_alive = KeepAlive(30, 10, 0.0)
    keep_alive.heard_at = 29.0
    assert keep_alive.check(30.0) is LifeSign.PING


@pytest.mark.virtual_time
@pytest.mark.parametrize("at", [1.0, 29.9, 30.1, 44.0, 1000.0])
async def test_a_frozen_link_is_noticed_in_time(at: float) -> None:
    async with MemoryBroker() as memory:
        client = memory.make_client(MqttOptions.from_url(memory.url, client_id="hub", keep_alive=30))
        async with client.connected():
            await anyio.sleep(at)
            memory.link_of("hub").freeze()
            began = anyio.current_time()
            reason = await client.wait_lost()
    assert isinstance(reason, LinkError)
    assert anyio.current_time() - began <= 46


async def test_a_proxy_that_stops_forwarding_is_noticed_in_time() -> None:
    """By aiomqtt, which has real sockets alone; the connection stays open, nothing comes or goes."""
    frozen = anyio.Event()

    async def forward(source: SocketStream, target: SocketStream) -> None:
        async for data in source:
            if frozen.is_set():
                await anyio.sleep_forever()
            await target.send(data)

    async with Broker() as real, await anyio.create_tcp_listener(local_host="127.0.0.1") as listener:

        async def carry(client: SocketStream) -> None:
            async with (
                client,
                await anyio.connect_tcp(real.host, real.port) as server,
                anyio.create_task_group() as both,
            ):
                both.start_soon(forward, client, server)
                both.start_soon(forward, server, client)

        lateness = Lateness()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, carry)
            tasks.start_soon(lateness.watch)
            port = listener.extra(SocketAttribute.local_port)  # noqa: S610 - no database
            hub = AiomqttClient(MqttOptions(host="127.0.0.1", port=port, keep_alive=5, client_id="hub"))
            with anyio.fail_after(PATIENCE):
                async with hub.connected():
                    frozen.set()
                    began = anyio.current_time()
                    reason = await hub.wait_lost()
                    took = anyio.current_time() - began
            tasks.cancel_scope.cancel()
    assert str(reason) == "the broker stopped responding"
    assert took - lateness.seconds <= 5 * 1.5 + 1


async def test_the_broker_may_ask_for_a_shorter_interval(make: MakeClient) -> None:
    async def script(peer: Peer) -> None:
        await peer.login(server_keep_alive=1)
        await peer.closed()

    lateness = Lateness()
    async with broker(script) as port, anyio.create_task_group() as tasks:
        tasks.start_soon(lateness.watch)
        client = make(port, keep_alive=600)
        async with client.connected():
            began = anyio.current_time()
            await client.wait_lost()
            took = anyio.current_time() - began
        tasks.cancel_scope.cancel()
    assert 1 < took < 2.5 + lateness.seconds
