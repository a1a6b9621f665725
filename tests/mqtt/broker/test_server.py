"""The broker on real sockets: listening, stopping, restarting, closing with a reason."""

import contextlib
import socket
import ssl

import anyio
import pytest
import trustme
from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Dial, WireClient
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.clock import ManualClock
from homebot.errors import LinkError, UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import Broker, BrokerLimits, PortTakenError
from homebot.mqtt.broker.authentication import Authentication

V31, V311, V5 = mqtt.ProtocolVersion.V31, mqtt.ProtocolVersion.V311, mqtt.ProtocolVersion.V5
FOREVER = mqtt.Properties(session_expiry_interval=0xFFFF_FFFF)


async def test_entering_means_listening_and_leaving_means_gone(dial: Dial) -> None:
    async with Broker(port=reserve_port()) as broker:
        assert broker.running
        assert broker.url == f"mqtt://127.0.0.1:{broker.port}"
        client, older = await dial(broker), await dial(broker, "b", V311)
    assert not broker.running
    assert await client.rest() == [mqtt.Disconnect(mqtt.ReasonCode.SERVER_SHUTTING_DOWN)]
    assert await older.rest() == []
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind((broker.host, broker.port))
    assert broker.stats.clients == 0


async def test_a_taken_port_is_named_with_what_to_do() -> None:
    async with Broker(port=reserve_port()) as first:
        second = Broker(port=first.port)
        with pytest.raises(PortTakenError, match=rf"port {first.port} .* choose another port") as caught:
            await second.start()
        assert caught.value.port == first.port
    async with second:
        assert second.port == first.port


async def test_an_address_that_is_not_here_is_a_link_error() -> None:
    with pytest.raises(LinkError, match=r"cannot listen on 192\.0\.2\.1"):
        await Broker(host="192.0.2.1", credentials={"a": "b"}).start()
    with pytest.raises(LinkError, match="no-such-host"):
        await Broker(host="no-such-host.invalid", credentials={"a": "b"}).start()


async def test_starting_and_stopping_twice_is_harmless() -> None:
    broker = Broker()
    with pytest.raises(UsageError, match="never started"):
        _ = broker.stats
    await broker.stop()
    async with broker:
        port = broker.port
        await broker.start()
        assert broker.port == port
        await broker.stop()
        await broker.stop()


@pytest.mark.parametrize("abrupt", [False, True])
async def test_a_restart_keeps_port_sessions_and_retained_messages(dial: Dial, *, abrupt: bool) -> None:
    async with Broker() as broker:
        port = broker.port
        client = await dial(broker, will=mqtt.Will("gone", b"1", retain=True), properties=FOREVER)
        await client.call(mqtt.Subscribe(1, (mqtt.MqttSubscription("t/#", 1),)))
        publisher = await dial(broker, "p")
        await publisher.call(mqtt.Publish("t/1", b"kept", 1, retain=True, packet_id=1))
        await broker.restart(keep_sessions=True, abrupt=abrupt)
        assert broker.port == port
        assert broker.stats.retained_messages == 1
        goodbye = [] if abrupt else [mqtt.Disconnect(mqtt.ReasonCode.SERVER_SHUTTING_DOWN)]
        assert await _until_cut(publisher) == goodbye
        client = await dial(broker, clean_start=False, properties=FOREVER)
        again = await client.take()
        assert isinstance(again, mqtt.Publish)
        assert (again.payload, again.dup) == (b"kept", True)


async def test_a_restart_may_forget_everything(dial: Dial) -> None:
    async with Broker() as broker:
        client = await dial(broker, properties=FOREVER)
        await client.call(mqtt.Publish("t", b"x", 1, retain=True, packet_id=1))
        await broker.restart(keep_sessions=False)
        assert (broker.stats.sessions, broker.stats.retained_messages) == (0, 0)
        assert broker.stats.messages_received == 1


async def test_clients_that_do_not_read_do_not_hold_up_a_stop(dial: Dial) -> None:
    limits = BrokerLimits(stop_timeout=0.05, linger=10 * PATIENCE)
    async with Broker(limits=limits) as broker:
        client = await dial(broker)
        client.writer.transport.pause_reading()  # type: ignore[attr-defined] # a socket transport
        with anyio.fail_after(PATIENCE):
            await broker.stop()


async def test_a_client_that_is_still_sending_reads_why_it_was_closed(dial: Dial) -> None:
    async with Broker(limits=BrokerLimits(linger=0.2)) as broker:
        client = await dial(broker)
        flood = mqtt.encode(mqtt.Publish("t", bytes(1000))) * 2000
        client.writer.write(b"\xc0\x01\x00" + flood)
        (goodbye,) = await client.rest()
        assert isinstance(goodbye, mqtt.Disconnect)
        assert goodbye.reason is mqtt.ReasonCode.MALFORMED_PACKET


async def test_one_bad_client_does_not_disturb_the_others(dial: Dial) -> None:
    async with Broker() as broker:
        good = await dial(broker, "good")
        for junk in (b"\x00" * 50, b"GET / HTTP/1.1\r\n\r\n", b"\x10\xff\xff\xff\xff", b"\x16\x03\x01"):
            bad = await dial(broker, None)
            await bad.send_bytes(junk)
            assert await bad.rest() == []
        assert await good.call(mqtt.Pingreq()) == mqtt.Pingresp()
        assert broker.stats.connections_failed == 4


async def test_a_socket_that_is_full_costs_qos_0_messages_but_no_qos_1_message(dial: Dial) -> None:
    async with Broker(limits=BrokerLimits(write_buffer=100_000)) as broker:
        slow, publisher = await dial(broker, "s"), await dial(broker, "p")
        await slow.call(mqtt.Subscribe(1, (mqtt.MqttSubscription("t", 1),)))
        for _ in range(100):
            await publisher.send(mqtt.Publish("t", bytes(200_000)))
        assert await publisher.call(mqtt.Publish("t", b"last", 1, packet_id=1)) == mqtt.Puback(1)
        messages = [await slow.take()]
        while messages[-1] != mqtt.Publish("t", b"last", 1, packet_id=1):
            messages.append(await slow.take())
        assert broker.stats.dropped_qos0 == 101 - len(messages) > 0


async def test_one_message_that_fills_the_socket_does_not_cost_those_behind_it(dial: Dial) -> None:
    async with Broker(limits=BrokerLimits(write_buffer=100_000)) as broker:
        slow, publisher = await dial(broker, "s"), await dial(broker, "p")
        await slow.call(mqtt.Subscribe(1, (mqtt.MqttSubscription("t", 0),)))
        await publisher.send(mqtt.Publish("t", bytes(12_000_000)))
        for _ in range(10):
            await publisher.send(mqtt.Publish("t", bytes(5_000)))
        assert await publisher.call(mqtt.Publish("t", b"last", 1, packet_id=1)) == mqtt.Puback(1)
        messages = [await slow.take() for _ in range(12)]
        sizes = [len(message.payload) for message in messages if isinstance(message, mqtt.Publish)]
        assert sizes == [12_000_000, *[5_000] * 10, 4]
        assert broker.stats.dropped_qos0 == 0


async def test_a_clock_moved_by_hand_needs_a_tick(dial: Dial) -> None:
    clock = ManualClock(5.0)
    async with Broker(clock=clock) as broker:
        client = await dial(broker, properties=mqtt.Properties(session_expiry_interval=3600))
        await client.send(mqtt.Disconnect())
        assert await client.rest() == []
        clock.advance(3600)
        broker.tick()
        assert broker.stats.sessions == 0


async def test_deadlines_come_by_themselves(dial: Dial) -> None:
    async with Broker(limits=BrokerLimits(connect_timeout=0.02)) as broker:
        client = await dial(broker, None)
        assert await client.rest() == []


async def test_a_fault_of_ours_costs_one_connection_only(dial: Dial) -> None:
    class Broken:
        def subscribe(self, client_id: str, filter: str) -> mqtt.ReasonCode:  # noqa: A002 - fills the port
            raise RuntimeError(f"{client_id} {filter}")

        def publish(self, client_id: str, topic: str) -> mqtt.ReasonCode:
            raise RuntimeError(f"{client_id} {topic}")

    with capture_logs() as lines:
        async with Broker(policy=Broken()) as broker:
            good, bad = await dial(broker, "good"), await dial(broker, "bad")
            await bad.send(mqtt.Publish("t"))
            assert await bad.rest() == [mqtt.Disconnect(mqtt.ReasonCode.IMPLEMENTATION_SPECIFIC_ERROR)]
            assert await good.call(mqtt.Pingreq()) == mqtt.Pingresp()
    assert [line["error"] for line in lines if line["event"] == "broker.internal_error"] == ["RuntimeError('bad t')"]


async def test_password_and_names_of_hosts(dial: Dial) -> None:
    async with Broker(host="localhost", credentials={"ann": "right"}) as broker:
        await dial(broker, username="ann", password=b"right")
        client = await dial(broker, None)
        await client.send(mqtt.Connect("x", username="ann", password=b"wrong"))
        assert [getattr(each, "reason", None) for each in await client.rest()] == [
            mqtt.ReasonCode.BAD_USER_NAME_OR_PASSWORD
        ]


@pytest.fixture
def authority() -> trustme.CA:
    return trustme.CA()


@pytest.fixture
def tls(authority: trustme.CA) -> ssl.SSLContext:
    server = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    authority.issue_cert("127.0.0.1").configure_cert(server)
    return server


async def test_tls_clients_are_served_and_closed_with_a_reason(
    dial: Dial, authority: trustme.CA, tls: ssl.SSLContext
) -> None:
    trusting = ssl.create_default_context()
    authority.configure_trust(trusting)
    async with Broker(tls=tls) as broker:
        assert broker.url.startswith("mqtts://")
        client = await dial(broker, context=trusting)
        assert await client.call(mqtt.Pingreq()) == mqtt.Pingresp()
        await client.send_bytes(b"\xc0\x01\x00")
        assert [getattr(each, "reason", None) for each in await client.rest()] == [mqtt.ReasonCode.MALFORMED_PACKET]


async def test_a_broker_stops_after_a_failed_tls_handshake(tls: ssl.SSLContext) -> None:
    """Somebody who speaks no TLS never becomes a connection, so the stop does not wait for one."""
    async with Broker(tls=tls) as broker:
        stranger = await anyio.connect_tcp("127.0.0.1", broker.port)
        await stranger.send(b"GET / HTTP/1.1\r\n\r\n")
        with anyio.fail_after(PATIENCE), contextlib.suppress(anyio.EndOfStream, anyio.BrokenResourceError):
            await stranger.receive()
        with anyio.fail_after(PATIENCE):
            await broker.stop()
        await stranger.aclose()


async def _take_and_acknowledge(client: WireClient) -> int:
    message = await client.take()
    assert isinstance(message, mqtt.Publish)
    await client.send(mqtt.Puback(message.packet_id or 0))
    return int.from_bytes(message.payload, "big")


async def _until_cut(client: WireClient) -> list[mqtt.Packet]:
    try:
        return await client.rest()
    except ConnectionError:
        return []


@pytest.mark.parametrize(
    "limits", [{"max_inflight": 0}, {"receive_maximum": 65_536}, {"max_packet_size": 2**28 + 5}, {"linger": -1}]
)
def test_bounds_that_cannot_work_are_refused_by_name(limits: dict[str, int]) -> None:
    with pytest.raises(UsageError, match=next(iter(limits))):
        BrokerLimits(**limits)


@pytest.mark.parametrize("host", ["::", "192.168.1.5", "my-computer", ""])
def test_an_address_others_can_reach_needs_a_password(host: str) -> None:
    with pytest.raises(UsageError, match="user and password"):
        Broker(host=host)
    assert Broker(host=host, credentials={"u": "p"}).host == host


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost", "127.8.8.8"])
def test_this_computer_needs_none(host: str) -> None:
    assert Broker(host=host).port == 0


def test_impossible_arguments_are_refused() -> None:
    with pytest.raises(UsageError, match="65536 is not a TCP port"):
        Broker(port=65_536)
    with pytest.raises(UsageError, match="keep-alive of 0"):
        Broker(keep_alive=0)


def test_passwords_are_shown_nowhere() -> None:
    broker = Broker(credentials={"ann": "hush"})
    assert "hush" not in repr(broker) + repr(vars(broker)) + repr(Authentication({"ann": "hush"}))
