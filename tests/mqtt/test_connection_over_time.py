"""Hours of a connection's life on a real broker in memory, in milliseconds."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace
from random import Random

import anyio
import pytest

from homebot.errors import RefusedError
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import OFFLINE, ONLINE, ConnectionState, LinkPhase, MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.support.backoff import REFUSED_BACKOFF

pytestmark = pytest.mark.virtual_time

HOUR = 3_600.0


@pytest.fixture
async def broker() -> AsyncIterator[MemoryBroker]:
    async with MemoryBroker() as broker:
        yield broker


@pytest.fixture
def options(broker: MemoryBroker) -> MqttOptions:
    return MqttOptions.from_url(broker.url, client_id="hub", keep_alive=60)


def connection_to(broker: MemoryBroker, options: MqttOptions, *, status_topic: str | None = None) -> MqttConnection:
    random = Random(1)  # noqa: S311 - jitter is no secret
    return MqttConnection(options, broker.make_client, status_topic=status_topic, random=random)


def now() -> float:
    return asyncio.get_running_loop().time()


async def received(connection: MqttConnection) -> list[bytes]:
    messages = await connection.receive()
    connection.ack(messages)
    return [message.payload for message in messages]


async def test_after_a_night_without_broker_the_link_is_back_within_half_a_minute(
    broker: MemoryBroker, options: MqttOptions
) -> None:
    """The tries become rare: not a thousand in eight hours and not one in an hour."""
    tries: list[ConnectionState] = []

    async def count(connection: MqttConnection) -> None:
        tries.extend([state async for state in connection.states() if state.phase is LinkPhase.WAITING])

    async with anyio.create_task_group() as tasks, connection_to(broker, options) as connection:
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("t", 1))
        tasks.start_soon(count, connection)
        await broker.stop(abrupt=True)
        await anyio.sleep(8 * HOUR)
        await broker.start()
        back = now()
        await connection.wait_connected()
        assert now() - back <= 30.0
        await connection.publish("t", b"x", qos=1)
        assert await received(connection) == [b"x"]
    assert 8 * HOUR / 30 < len(tries) < 3_000
    assert max(state.retry_in or 0.0 for state in tries) > 25.0


async def test_a_broker_that_says_no_is_asked_at_most_every_few_minutes(options: MqttOptions) -> None:
    async with (
        MemoryBroker(credentials={"anna": "right"}) as broker,
        connection_to(broker, options) as connection,
    ):
        await anyio.sleep(8 * HOUR)
        assert broker.stats.connections_refused < 8 * HOUR / 150 + 10
        with pytest.raises(RefusedError, match="not authorized"):
            await connection.wait_connected()


async def test_a_broker_that_says_no_when_it_is_back_is_asked_again_soon(options: MqttOptions) -> None:
    """Mosquitto of Home Assistant refuses everybody until Home Assistant runs."""
    async with MemoryBroker(credentials={"anna": "right"}) as broker:
        await broker.stop(abrupt=True)
        async with connection_to(broker, options) as connection:
            await anyio.sleep(HOUR)
            await broker.start()
            with pytest.raises(RefusedError):
                await connection.wait_connected()
            assert (connection.state.retry_in or 0.0) <= REFUSED_BACKOFF.first


async def test_what_was_said_while_the_link_was_frozen_comes_after_it(
    broker: MemoryBroker, options: MqttOptions
) -> None:
    """A cable is out for an hour; the broker keeps the session that long."""
    kept = replace(options, session_expiry=2 * 3_600)
    sender = connection_to(broker, replace(options, client_id="sender"))
    async with connection_to(broker, kept) as hub, sender:
        await hub.wait_connected()
        await sender.wait_connected()
        await hub.subscribe(MqttSubscription("t", 1))
        broker.link_of("hub").freeze()
        for number in range(3):
            await anyio.sleep(HOUR / 3)
            await sender.publish("t", b"%d" % number, qos=1)
        got: list[bytes] = []
        while len(got) < 3:
            got += await received(hub)
        assert sorted(set(got)) == [b"0", b"1", b"2"]


async def test_a_session_that_ended_meanwhile_is_built_anew(broker: MemoryBroker, options: MqttOptions) -> None:
    async with connection_to(broker, replace(options, session_expiry=60)) as connection:
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("t", 1))
        await broker.restart(keep_sessions=False, abrupt=True)
        await anyio.sleep(10)
        await connection.publish("t", b"x", qos=1)
        assert await received(connection) == [b"x"]


async def test_who_is_silent_for_too_long_is_offline_for_all_to_see(broker: MemoryBroker, options: MqttOptions) -> None:
    """And online again when it is back."""
    watcher = connection_to(broker, replace(options, client_id="watcher"))
    async with watcher:
        await watcher.subscribe(MqttSubscription("status", 1))
        async with connection_to(broker, options, status_topic="status") as hub:
            await hub.wait_connected()
            assert await received(watcher) == [ONLINE]
            broker.link_of("hub").freeze()
            frozen = now()
            seen = [*await received(watcher), *await received(watcher)]
            assert (seen[0], seen[-1]) == (OFFLINE, ONLINE)
            assert now() - frozen < 100.0


async def test_a_week_of_idling_keeps_the_link(broker: MemoryBroker, options: MqttOptions) -> None:
    async with connection_to(broker, options) as connection:
        await connection.wait_connected()
        await anyio.sleep(7 * 24 * HOUR)
        assert connection.state.phase is LinkPhase.CONNECTED
        assert broker.stats.connections_accepted == 1
