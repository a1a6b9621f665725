"""TLS at the broker, over real sockets."""

import asyncio
import ssl
from collections.abc import AsyncIterator
from datetime import UTC, datetime

import anyio
import pytest
from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Dial
from tests.patience import PATIENCE, until

from homebot.mqtt.broker import Broker, BrokerLimits
from homebot.mqtt.packets import Connect, MqttSubscription, Pingreq, Pingresp, Puback, Publish, Subscribe, encode
from homebot.testing.mqtt.settings import TestTls


@pytest.fixture(scope="module")
def tls(tmp_path_factory: pytest.TempPathFactory) -> TestTls:
    return TestTls.make(tmp_path_factory.mktemp("tls"), datetime.now(UTC))


@pytest.fixture
def trusting(tls: TestTls) -> ssl.SSLContext:
    return ssl.create_default_context(cafile=str(tls.ca_file))


@pytest.fixture
async def broker(tls: TestTls) -> AsyncIterator[Broker]:
    async with Broker(tls=tls.context, limits=BrokerLimits(max_waiting_logins=20)) as broker:
        yield broker


async def test_hand_shakes_that_do_not_end_make_room_for_others(
    broker: Broker, dial: Dial, trusting: ssl.SSLContext
) -> None:
    """They count as connections that have not logged in, and take no more memory."""
    silent = [await asyncio.open_connection(broker.host, broker.port) for _ in range(100)]
    await until(lambda: broker.stats.logins_pushed_out >= 80)
    assert len(broker.state.waiting_logins) <= 20
    client = await dial(broker, "honest", context=trusting)
    assert await client.call(Pingreq()) == Pingresp()
    assert broker.stats.logins_pushed_out >= 80
    for _, writer in silent:
        writer.close()


async def test_a_hand_shake_has_a_deadline(tls: TestTls) -> None:
    async with Broker(tls=tls.context, limits=BrokerLimits(connect_timeout=0.1)) as broker:
        reader, writer = await asyncio.open_connection(broker.host, broker.port)
        with anyio.fail_after(PATIENCE):
            assert await reader.read() == b""
        writer.close()
        assert broker.stats.connections_failed == 1


async def test_a_hand_shake_in_single_bytes_succeeds(broker: Broker, trusting: ssl.SSLContext) -> None:
    """And so do packets that come so, and several that come in one record."""
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = trusting.wrap_bio(incoming, outgoing, server_hostname="127.0.0.1")
    reader, writer = await asyncio.open_connection(broker.host, broker.port)

    async def send() -> None:
        for byte in outgoing.read():
            writer.write(bytes([byte]))
            await writer.drain()

    async def receive(size: int) -> bytes:
        data = b""
        while len(data) < size:
            try:
                data += client.read(1000)
            except ssl.SSLWantReadError:
                incoming.write(await reader.read(1000))
        return data

    with anyio.fail_after(PATIENCE):
        while True:
            try:
                client.do_handshake()
                break
            except ssl.SSLWantReadError:
                await send()
                incoming.write(await reader.read(1000))
        client.write(encode(Connect("bytes")) + b"\xc0\0" * 3)
        await send()
        assert (await receive(11)).endswith(b"\xd0\0" * 3)
    writer.close()


async def test_large_messages_go_both_ways(broker: Broker, dial: Dial, trusting: ssl.SSLContext) -> None:
    receiver = await dial(broker, "r", context=trusting)
    sender = await dial(broker, "s", context=trusting)
    await receiver.call(Subscribe(1, (MqttSubscription("t", 1),)))
    payload = bytes(range(256)) * 12_000
    with anyio.fail_after(PATIENCE):
        await sender.send(Publish("t", payload, 1, packet_id=1))
        message = await receiver.take()
        assert isinstance(message, Publish)
        assert message.payload == payload
        assert await sender.take() == Puback(1)


async def test_a_publisher_is_held_back_for_a_slow_reader(tls: TestTls, dial: Dial, trusting: ssl.SSLContext) -> None:
    """What was read of its records waits, and goes on in order."""
    limits = BrokerLimits(max_queued_messages=200, max_held_packets=50, receive_maximum=60_000, max_inflight=10)
    async with Broker(tls=tls.context, limits=limits) as broker:
        slow = await dial(broker, "s", context=trusting)
        publisher = await dial(broker, "p", context=trusting)
        await slow.call(Subscribe(1, (MqttSubscription("t", 1),)))
        await publisher.send(*(Publish("t", b"%d" % number, 1, packet_id=number) for number in range(1, 1001)))
        received: list[int] = []
        with anyio.fail_after(PATIENCE):
            while len(received) < 1000:
                message = await slow.take()
                assert isinstance(message, Publish)
                received.append(int(message.payload))
                await slow.send(Puback(message.packet_id or 0))
        assert received == list(range(1, 1001))
        assert broker.stats.dropped_overrun == 0


async def test_who_speaks_no_tls_is_told_of(broker: Broker) -> None:
    with capture_logs() as lines:
        reader, writer = await asyncio.open_connection(broker.host, broker.port)
        writer.write(b"\x10\x0c\x00\x04MQTT\x04\x02\x00\x3c\x00\x00")
        with anyio.fail_after(PATIENCE):
            await reader.read()
        writer.close()
    (told,) = [line["message"] for line in lines if line["event"] == "broker.tls_failed"]
    assert told.endswith("and the broker could not establish TLS: wrong version number")


async def test_a_client_that_goes_in_the_middle_leaves_nothing(
    broker: Broker, dial: Dial, trusting: ssl.SSLContext
) -> None:
    for _ in range(10):
        _, writer = await asyncio.open_connection(broker.host, broker.port)
        writer.write(b"\x16\x03\x01\x02\x00\x01")
        writer.close()
    client = await dial(broker, context=trusting)
    await client.close()
    with anyio.fail_after(PATIENCE):
        while broker.stats.clients or len(broker._sockets):  # noqa: ASYNC110 - no event tells
            await anyio.sleep(0.01)
    assert len(broker.state.waiting_logins) == 0
