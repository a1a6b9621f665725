"""The adapter against a broker that plays a script: every known trouble of the library, and what became of it."""

from __future__ import annotations

import asyncio
import gc
import logging
import socket
import struct
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Any, TypeVar

import anyio
import pytest
from anyio.abc import SocketAttribute, SocketStream
from structlog.testing import capture_logs

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.message import MessageProperties
from homebot.mqtt.options import MqttOptions, MqttProtocol, MqttWill
from homebot.mqtt.packets import (
    Connack,
    Connect,
    Disconnect,
    Packet,
    PacketReader,
    Pingreq,
    Properties,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
    Suback,
    Subscribe,
    Unsuback,
    Unsubscribe,
    encode,
)

P = TypeVar("P", bound=Packet)


class Peer:
    """One connection, seen from the broker."""

    def __init__(self, stream: SocketStream) -> None:
        self._stream = stream
        self._reader = PacketReader()

    async def expect(self, kind: type[P]) -> P:
        packet = await self.next()
        assert isinstance(packet, kind), packet
        return packet

    async def next(self) -> Packet:
        while (packet := self._reader.pop()) is None or isinstance(packet, Pingreq):
            self._reader.feed(await self._stream.receive())
        return packet

    async def send(self, *packets: Packet) -> None:
        await self.send_raw(b"".join(encode(packet, self._reader.version) for packet in packets))

    async def send_raw(self, data: bytes) -> None:
        await self._stream.send(data)

    async def login(self, *, session_present: bool = False, **properties: int) -> Connect:
        connect = await self.expect(Connect)
        self._reader.version = connect.version
        granted = Properties(**properties)  # type: ignore[arg-type] # whole numbers only
        await self.send(Connack(session_present=session_present, properties=granted))
        return connect

    async def closed(self) -> None:
        """Wait until the client has closed the connection."""
        try:
            async for _ in self._stream:
                pass
        except anyio.BrokenResourceError:
            return


Script = Callable[[Peer], Awaitable[None]]


@asynccontextmanager
async def broker(*scripts: Script) -> AsyncIterator[int]:
    """A port where the n-th connection meets the n-th script; leaving waits until all are played."""
    left = list(scripts)
    done = anyio.Event()

    async def play(stream: SocketStream) -> None:
        script = left.pop(0)
        async with stream:
            await script(Peer(stream))
        if not left:
            done.set()

    listener = await anyio.create_tcp_listener(local_host="127.0.0.1")
    with anyio.fail_after(10):
        async with listener, anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, play)
            yield listener.extra(SocketAttribute.local_port)  # noqa: S610 - no database
            await done.wait()
            tasks.cancel_scope.cancel()


def make(port: int, *, timeout: float = 60.0, **settings: Any) -> AiomqttClient:
    return AiomqttClient(MqttOptions(host="127.0.0.1", port=port, timeout=timeout, **settings))


async def idle(peer: Peer) -> None:
    """Let the client in, and wait until it says good-bye."""
    await peer.login()
    await peer.expect(Disconnect)


# -- receiving ------------------------------------------------------------------------------------------------


async def test_a_message_is_acknowledged_only_when_it_was_handed_over() -> None:
    """The library does it on arrival; a crash then loses the message."""

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(Publish("t", b"x", 1, packet_id=7))
        assert (await peer.expect(Publish)).topic == "marker"
        assert (await peer.expect(Puback)).packet_id == 7
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected():
        batch = await client.receive()
        await client.publish("marker")
        client.ack(batch)


async def test_qos_2_is_handed_over_once_and_only_then_recorded() -> None:
    released = anyio.Event()

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(Publish("t", b"x", 2, packet_id=7), Publish("t", b"x", 2, dup=True, packet_id=7))
        await peer.send(Publish("t", b"last"))
        assert (await peer.expect(Publish)).topic == "marker"
        await peer.expect(Pubrec)
        await peer.send(Pubrel(7))
        assert (await peer.expect(Pubcomp)).packet_id == 7
        released.set()
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected():
        batch = await receive(client, 2)
        assert [message.payload for message in batch] == [b"x", b"last"]
        await client.publish("marker")
        client.ack(batch)
        await released.wait()


async def test_unread_messages_of_qos_0_are_dropped_oldest_first_and_counted() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(*(Publish("t", b"%d" % n) for n in range(100)), Publish("t", b"end", 1, packet_id=1))
        await peer.send(Puback((await peer.expect(Publish)).packet_id or 0))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port, inbox_messages=10)).connected():
        await client.publish("marker", qos=1)  # its answer comes behind the messages
        batch = await client.receive()
    assert [message.payload for message in batch] == [b"%d" % n for n in range(90, 100)] + [b"end"]
    assert client.counters.dropped_overflow == 90


async def test_the_window_for_unacknowledged_messages_and_the_size_limit_are_announced() -> None:
    async def script(peer: Peer) -> None:
        properties = (await peer.login()).properties
        assert properties.receive_maximum == 17
        assert properties.maximum_packet_size == 2000
        assert properties.session_expiry_interval == 60
        assert properties.topic_alias_maximum is None, "the library cannot resolve topic aliases"
        await peer.expect(Disconnect)

    async with (
        broker(script) as port,
        make(port, receive_maximum=17, maximum_packet_size=2000, session_expiry=60).connected(),
    ):
        pass


@pytest.mark.parametrize("version", ["5", "3.1.1"])
async def test_a_bad_message_costs_no_more_than_itself(version: MqttProtocol) -> None:
    """It is acknowledged, so that it does not come for ever, and counted; the next one arrives."""
    properties = b"\x00" if version == "5" else b""
    bodies = [
        b"\x00\x02\xc3\x28\x00\x01" + properties,  # a topic that is not UTF-8
        b"\x00\x03a/#\x00\x02" + properties,
        b"\x00\x03a\x00b\x00\x03" + properties,
    ]
    if version == "5":
        bodies.append(b"\x00\x01a\x00\x04\x02\x7f\x00")  # an unknown property

    async def script(peer: Peer) -> None:
        await peer.login()
        for body in bodies:
            await peer.send_raw(bytes([0x32, len(body)]) + body)
        await peer.send(Publish("good", b"", 1, packet_id=9))
        assert [(await peer.expect(Puback)).packet_id for _ in bodies] == list(range(1, len(bodies) + 1))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port, protocol=version)).connected():
        (message,) = await client.receive()
        assert message.topic == "good"
    assert client.counters.dropped_malformed == len(bodies)


async def test_a_message_over_the_limit_is_dropped_acknowledged_and_counted() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(Publish("big", bytes(300_000), 1, packet_id=1), Publish("small", b""))
        assert (await peer.expect(Puback)).packet_id == 1
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port, protocol="3.1.1")).connected():
        (message,) = await client.receive()
        assert message.topic == "small"
    assert client.counters.dropped_oversize == 1


async def test_an_unreadable_packet_ends_the_link_with_its_reason() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send_raw(b"\x90\x01\x00")
        await peer.closed()

    async with broker(script) as port, (client := make(port)).connected():
        assert "unreadable" in str(await client.wait_lost())
        with pytest.raises(LinkError):
            await client.receive()


# -- publishing -----------------------------------------------------------------------------------------------


async def test_a_refused_publish_is_an_error() -> None:
    """The library returns as if all were well."""

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(Puback((await peer.expect(Publish)).packet_id or 0, ReasonCode.NOT_AUTHORIZED))
        await peer.send(Pubrec((await peer.expect(Publish)).packet_id or 0, ReasonCode.QUOTA_EXCEEDED))
        await peer.send(Puback((await peer.expect(Publish)).packet_id or 0, ReasonCode.NO_MATCHING_SUBSCRIBERS))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected():
        with pytest.raises(RefusedError, match="publish to 'secret/door' was refused: not authorized") as caught:
            await client.publish("secret/door", qos=1)
        assert caught.value.code == 0x87
        with pytest.raises(RefusedError, match="quota exceeded"):
            await client.publish("t", qos=2)
        assert (await client.publish("t", qos=1)).reason == 0x10


async def test_a_publish_in_flight_fails_at_once_when_the_link_drops() -> None:
    """The library waits for its time limit, 10 s by default."""

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Publish)

    async with broker(script) as port, (client := make(port)).connected():
        with anyio.fail_after(5), pytest.raises(LinkError, match="the broker closed the connection"):
            await client.publish("t", qos=1)
        with pytest.raises(LinkError):
            await client.publish("t")
        with pytest.raises(LinkError):
            await client.subscribe(MqttSubscription("t"))


async def test_a_subscription_in_flight_fails_at_once_when_the_link_drops() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Subscribe)

    async def second(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Unsubscribe)

    async with broker(script, second) as port:
        client = make(port)
        with anyio.fail_after(5):
            async with client.connected():
                with pytest.raises(LinkError):
                    await client.subscribe(MqttSubscription("t"))
            async with client.connected():
                with pytest.raises(LinkError):
                    await client.unsubscribe("t")


async def test_a_silent_broker_is_a_link_error() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Publish)
        await peer.expect(Subscribe)
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port, timeout=0.02)).connected():
        with pytest.raises(LinkError, match=r"no answer to a publish within 0\.02 s"):
            await client.publish("t", qos=1)
        with pytest.raises(LinkError, match="no answer to subscribe"):
            await client.subscribe(MqttSubscription("t"))


async def test_the_window_of_the_broker_is_respected() -> None:
    """The library ignores Receive Maximum; a broker then closes the link and all is lost."""
    at_rest = anyio.Event()

    async def script(peer: Peer) -> None:
        await peer.login(receive_maximum=3)
        first = [await peer.expect(Publish) for _ in range(3)]
        at_rest.set()
        assert (await peer.expect(Publish)).topic == "marker"
        for publish in first:
            await peer.send(Puback(publish.packet_id or 0))
        for _ in range(7):
            await peer.send(Puback((await peer.expect(Publish)).packet_id or 0))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected(), anyio.create_task_group() as tasks:
        for _ in range(10):
            tasks.start_soon(lambda: client.publish("t", qos=1))
        await at_rest.wait()
        await client.publish("marker")


async def test_many_publishes_at_once_make_no_noise(caplog: pytest.LogCaptureFixture) -> None:
    """The library warns from ten on, each time."""

    async def script(peer: Peer) -> None:
        await peer.login()
        for _ in range(200):
            await peer.send(Puback((await peer.expect(Publish)).packet_id or 0))
        await peer.expect(Disconnect)

    with caplog.at_level(logging.DEBUG):
        async with broker(script) as port, (client := make(port)).connected(), anyio.create_task_group() as tasks:
            for _ in range(200):
                tasks.start_soon(lambda: client.publish("t", qos=1))
    assert [record for record in caplog.records if record.name != "asyncio"] == []


async def test_what_the_broker_cannot_take_is_refused_here() -> None:
    """Sent all the same, it would cost the link."""

    async def script(peer: Peer) -> None:
        await peer.login(maximum_qos=1, retain_available=0, maximum_packet_size=100)
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected():
        with pytest.raises(RefusedError, match="qos not supported"):
            await client.publish("t", qos=2)
        with pytest.raises(RefusedError, match="retain not supported"):
            await client.publish("t", retain=True)
        with pytest.raises(RefusedError, match="packet too large"):
            await client.publish("t", bytes(100))
        with pytest.raises(RefusedError, match="packet too large"):
            await client.publish("t", properties=MessageProperties(user=(("k", "v" * 100),)))


async def test_a_publish_that_is_none_is_a_usage_error() -> None:
    async with broker(idle) as port, (client := make(port)).connected():
        with pytest.raises(UsageError):
            await client.publish("a/+")
        with pytest.raises(UsageError):
            await client.publish("t", qos=3)
        with pytest.raises(UsageError, match="properties"):
            await client.publish("t", properties=MessageProperties(correlation_data=bytes(70_000)))
        with pytest.raises(UsageError):
            await client.subscribe(MqttSubscription("a/#/b"))


async def test_publishes_of_qos_0_wait_for_a_slow_broker() -> None:
    """The queue before the socket stays bounded, and a dropped link frees who waits."""
    stuffed = anyio.Event()

    async def script(peer: Peer) -> None:
        await peer.login()
        await stuffed.wait()

    async with broker(script) as port, (client := make(port)).connected():
        sent = 0

        async def flood() -> None:
            nonlocal sent
            try:
                while True:
                    await client.publish("t", bytes(60_000))
                    sent += 1
            except LinkError:
                return

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(flood)
            tasks.start_soon(flood)
            await anyio.wait_all_tasks_blocked()
            assert 0 < sent < 2000
            stuffed.set()


async def test_publishes_of_qos_0_go_on_when_a_slow_broker_reads_again() -> None:
    stuffed = anyio.Event()

    async def script(peer: Peer) -> None:
        await peer.login()
        await stuffed.wait()
        for _ in range(1200):
            await peer.expect(Publish)
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected(), anyio.create_task_group() as tasks:
        for _ in range(3):
            tasks.start_soon(flood, client, 400)
        await anyio.wait_all_tasks_blocked()
        stuffed.set()


# -- subscribing ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("version", "code", "words"),
    [("5", ReasonCode.NOT_AUTHORIZED, "not authorized"), ("3.1.1", ReasonCode.UNSPECIFIED_ERROR, "unspecified error")],
)
async def test_a_refused_subscription_is_an_error_that_names_the_filter(
    version: MqttProtocol, code: ReasonCode, words: str
) -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        subscribe = await peer.expect(Subscribe)
        await peer.send(Suback(subscribe.packet_id, (ReasonCode.GRANTED_QOS_1, code)))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port, protocol=version)).connected():
        with pytest.raises(RefusedError, match=f"subscription to 'secret/#' was refused: {words}") as caught:
            await client.subscribe(MqttSubscription("a", 1), MqttSubscription("secret/#", 1))
        assert caught.value.code == code


async def test_subscription_options_reach_the_broker() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        subscribe = await peer.expect(Subscribe)
        (wish,) = subscribe.filters
        assert (wish.filter, wish.qos, wish.no_local, wish.retain_as_published, wish.retain_handling) == (
            "a/#",
            2,
            True,
            True,
            2,
        )
        await peer.send(Suback(subscribe.packet_id, (ReasonCode.GRANTED_QOS_1,)))
        unsubscribe = await peer.expect(Unsubscribe)
        await peer.send(Unsuback(unsubscribe.packet_id, (ReasonCode.SUCCESS,)))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected():
        wish = MqttSubscription("a/#", 2, no_local=True, retain_as_published=True, retain_handling=2)
        assert await client.subscribe(wish) == (1,)
        await client.unsubscribe("a/#")


# -- the link -------------------------------------------------------------------------------------------------


async def test_login_and_will_reach_the_broker() -> None:
    async def script(peer: Peer) -> None:
        connect = await peer.login()
        assert (connect.client_id, connect.username, connect.password) == ("hub", "anna", b"pw")
        assert connect.keep_alive == 30
        assert connect.will is not None
        assert (connect.will.topic, connect.will.payload, connect.will.qos, connect.will.retain) == (
            "w",
            b"gone",
            1,
            True,
        )
        await peer.expect(Disconnect)

    async with broker(script) as port:
        options = MqttOptions.from_url(
            f"mqtt://anna:pw@127.0.0.1:{port}", client_id="hub", will=MqttWill("w", b"gone", 1, retain=True)
        )
        async with AiomqttClient(options).connected() as session:
            assert session.protocol == "5"


@pytest.mark.parametrize(
    "refusal",
    [
        encode(Connack(reason=ReasonCode.UNSUPPORTED_PROTOCOL_VERSION), ProtocolVersion.V5),
        bytes.fromhex("20 02 00 01"),  # as MQTT 3.1.1 says it
        b"",  # no word at all
    ],
)
async def test_a_broker_that_does_not_speak_5_is_asked_with_3_1_1(refusal: bytes) -> None:
    async def deaf(peer: Peer) -> None:
        assert (await peer.expect(Connect)).version is ProtocolVersion.V5
        if refusal:
            await peer.send_raw(refusal)

    async def old(peer: Peer) -> None:
        assert (await peer.login()).version is ProtocolVersion.V311
        await peer.expect(Disconnect)

    with capture_logs() as lines:
        async with broker(deaf, old, old) as port:
            client = make(port)
            for _ in range(2):  # the second time without asking for 5
                async with client.connected() as session:
                    assert session.protocol == "3.1.1"
    said = [line["message"] for line in lines if line["event"] == "mqtt.fell_back"]
    assert said == [f"mqtt://127.0.0.1:{port} speaks MQTT 3.1.1, not 5"]


@pytest.mark.parametrize(
    ("nonsense", "problem"),
    [
        (b"", r"the broker closed the connection instead of answering; is this a port for TLS \(mqtts://\)\?"),
        (b"\x15\x03\x01\x00\x02\x02\x46", "what answers there speaks TLS; is the address mqtts://"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n" + bytes(100), "what answers there speaks no MQTT"),
        (b"\xff" * 20, "what answers there speaks no MQTT"),
    ],
)
async def test_who_speaks_no_version_at_all_is_not_called_old(nonsense: bytes, problem: str) -> None:
    async def strange(peer: Peer) -> None:
        await peer.expect(Connect)
        if nonsense:
            await peer.send_raw(nonsense)

    with capture_logs() as lines:
        async with broker(strange, strange) as port:
            with pytest.raises(LinkError, match=problem):
                async with make(port).connected():
                    pass
    assert [line for line in lines if line["event"] == "mqtt.fell_back"] == []


async def test_a_broker_that_cuts_the_connection_instead_of_answering_gets_a_hint() -> None:
    """Brokers do so where TLS, or a client certificate, is missing."""

    async def cut(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read(1)
        writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        writer.transport.abort()  # a reset, not a good-bye

    async with await asyncio.start_server(cut, "127.0.0.1", 0) as server:
        hint = r"cut the connection instead of answering; is this a port for TLS \(mqtts://\)\?"
        with pytest.raises(LinkError, match=hint):
            async with make(server.sockets[0].getsockname()[1]).connected():
                pass


async def test_a_broker_that_spoke_5_before_is_not_asked_with_3_1_1_because_it_closed_once() -> None:
    async def restarting(peer: Peer) -> None:
        await peer.expect(Connect)

    async with broker(idle, restarting, idle) as port:
        client = make(port)
        async with client.connected():
            pass
        with pytest.raises(LinkError):
            async with client.connected():
                pass
        async with client.connected() as session:
            assert session.protocol == "5"


@pytest.mark.parametrize(
    ("code", "error"),
    [
        (ReasonCode.BAD_USER_NAME_OR_PASSWORD, RefusedError),
        (ReasonCode.NOT_AUTHORIZED, RefusedError),
        (ReasonCode.SERVER_BUSY, LinkError),
    ],
)
async def test_a_login_is_refused_or_put_off_and_no_secret_is_told(code: ReasonCode, error: type[Exception]) -> None:
    async def script(peer: Peer) -> None:
        await peer.expect(Connect)
        await peer.send(Connack(reason=code))

    async with broker(script) as port:
        options = MqttOptions.from_url(f"mqtt://anna:hunter2@127.0.0.1:{port}")
        with pytest.raises(error, match=code.name.lower().replace("_", " ")) as caught:
            async with AiomqttClient(options).connected():
                pass
    chain: BaseException | None = caught.value
    while chain is not None:
        assert "hunter2" not in f"{chain!r} {chain.args}"
        chain = chain.__cause__ or chain.__context__


async def test_an_absent_broker_is_a_link_error(unused_tcp_port: int) -> None:
    with pytest.raises(LinkError, match="nobody listens there"):
        async with make(unused_tcp_port).connected():
            pass


async def test_a_broker_that_does_not_answer_connect_is_a_link_error() -> None:
    async def script(peer: Peer) -> None:
        await peer.expect(Connect)
        await peer.closed()

    async with broker(script) as port:
        with pytest.raises(LinkError, match="no answer to CONNECT"):
            async with make(port, timeout=0.5).connected():
                pass


async def test_a_cancelled_connect_leaves_nothing_behind() -> None:
    """The library keeps its lock, a task and the socket, and cannot be used again."""
    asked = anyio.Event()

    async def silent(peer: Peer) -> None:
        await peer.expect(Connect)
        asked.set()
        await peer.closed()

    async def connect(client: AiomqttClient) -> None:
        async with client.connected():
            pytest.fail("there was no answer to CONNECT")

    async with broker(silent, idle) as port:
        client = make(port)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(connect, client)
            await asked.wait()
            tasks.cancel_scope.cancel()
        async with client.connected() as session:
            assert not session.resumed


async def test_a_session_is_taken_up_again_by_a_new_process_and_by_the_next_link() -> None:
    """The library's default cleans the session with the first CONNECT of each client object."""

    async def script(peer: Peer) -> None:
        connect = await peer.login(session_present=True)
        assert not connect.clean_start
        assert connect.properties.session_expiry_interval == 3600
        await peer.expect(Disconnect)

    async with broker(script, script) as port:
        client = make(port, session_expiry=3600, client_id="hub")
        for _ in range(2):
            async with client.connected() as session:
                assert session.resumed


@pytest.mark.parametrize("version", ["5", "3.1.1"])
async def test_without_session_expiry_every_link_starts_clean(version: MqttProtocol) -> None:
    async def script(peer: Peer) -> None:
        assert (await peer.login()).clean_start
        await peer.expect(Disconnect)

    async with broker(script, script) as port:
        client = make(port, protocol=version)
        for _ in range(2):
            async with client.connected():
                pass


async def test_an_open_qos_2_publish_is_brought_to_its_end_and_its_identifier_is_not_used_again() -> None:
    """A new client object would number from the start; the broker then swallows the next message as a repetition."""
    numbers: list[int | None] = []

    async def first(peer: Peer) -> None:
        await peer.login()
        numbers.append((await peer.expect(Publish)).packet_id)

    async def second(peer: Peer) -> None:
        await peer.login(session_present=True)
        again, other = await peer.expect(Publish), await peer.expect(Publish)
        assert (again.payload, again.dup, again.packet_id) == (b"one", True, numbers[0])
        numbers.append(other.packet_id)
        await finish(peer, again)
        await finish(peer, other)
        await peer.expect(Disconnect)

    async with broker(first, second) as port:
        client = make(port, session_expiry=60)
        async with client.connected():
            with pytest.raises(LinkError):
                await client.publish("t", b"one", qos=2)
        async with client.connected():
            await client.publish("t", b"two", qos=2)
    assert numbers[0] != numbers[1]


async def test_a_failed_publish_of_qos_1_does_not_fire_on_the_next_link() -> None:
    async def first(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Publish)

    async def second(peer: Peer) -> None:
        await peer.login(session_present=True)
        assert (await peer.expect(Publish)).payload == b"new"
        await peer.expect(Disconnect)

    async with broker(first, second) as port:
        client = make(port, session_expiry=60)
        async with client.connected():
            with pytest.raises(LinkError):
                await client.publish("t", b"old", qos=1)
        async with client.connected():
            await client.publish("t", b"new")


async def test_nothing_open_is_sent_into_a_lost_session() -> None:
    async def first(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Publish)

    async def second(peer: Peer) -> None:
        await peer.login(session_present=False)
        assert (await peer.expect(Publish)).payload == b"new"
        await peer.expect(Disconnect)

    async with broker(first, second) as port:
        client = make(port, session_expiry=60)
        async with client.connected():
            with pytest.raises(LinkError):
                await client.publish("t", b"old", qos=2)
        async with client.connected():
            await client.publish("t", b"new")


async def test_a_redelivered_message_is_acknowledged_on_its_own_link() -> None:
    async def first(peer: Peer) -> None:
        await peer.login()
        await peer.send(Publish("t", b"x", 1, packet_id=7))

    async def second(peer: Peer) -> None:
        await peer.login(session_present=True)
        await peer.send(Publish("t", b"x", 1, dup=True, packet_id=7))
        assert (await peer.expect(Publish)).topic == "marker"
        assert (await peer.expect(Puback)).packet_id == 7
        assert isinstance(await peer.next(), Disconnect)

    async with broker(first, second) as port:
        client = make(port, session_expiry=60)
        async with client.connected():
            old = await client.receive()
            await client.wait_lost()
        async with client.connected():
            new = await client.receive()
            client.ack(old)
            await client.publish("marker")
            client.ack(new)
        assert old == new


async def test_a_drop_with_unsent_data_makes_no_noise(caplog: pytest.LogCaptureFixture) -> None:
    """The library leaves bad file descriptors and futures that nobody reads to the loop's exception handler."""
    noise: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: noise.append(context))

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(Publish)

    async with broker(script) as port, (client := make(port)).connected():
        async with anyio.create_task_group() as tasks:
            for qos in (1, 1, 0, 2) * 20:
                tasks.start_soon(fail_to_publish, client, qos)
        await client.wait_lost()
        with pytest.raises(LinkError):
            await client.publish("t")
    del client
    gc.collect()
    assert noise == []
    assert [record for record in caplog.records if record.levelno >= logging.WARNING] == []


@pytest.mark.parametrize(
    ("code", "error"),
    [
        (ReasonCode.SESSION_TAKEN_OVER, RefusedError),
        (ReasonCode.ADMINISTRATIVE_ACTION, RefusedError),
        (ReasonCode.SERVER_SHUTTING_DOWN, LinkError),
    ],
)
async def test_the_brokers_good_bye_tells_why(code: ReasonCode, error: type[Exception]) -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(Disconnect(code))
        await peer.closed()

    async with broker(script) as port, (client := make(port)).connected():
        reason = await client.wait_lost()
    assert isinstance(reason, error)
    assert code.name.lower().replace("_", " ") in str(reason)


async def test_a_client_has_one_link_at_a_time() -> None:
    async with broker(idle) as port, (client := make(port)).connected():
        with pytest.raises(UsageError, match="connected already"):
            async with client.connected():
                pass


async def test_without_a_link_there_is_nothing_to_do() -> None:
    client = make(1)
    with pytest.raises(LinkError, match="not connected"):
        await client.publish("t")
    with pytest.raises(LinkError, match="not connected"):
        await client.receive()
    client.ack([])


async def receive(client: AiomqttClient, count: int) -> list[Any]:
    messages: list[Any] = []
    while len(messages) < count:
        messages += await client.receive()
    return messages


async def flood(client: AiomqttClient, count: int) -> None:
    for _ in range(count):
        await client.publish("t", bytes(30_000))


async def fail_to_publish(client: AiomqttClient, qos: int) -> None:
    try:
        await client.publish("t", bytes(50_000), qos=qos)
    except LinkError:
        return
    assert qos == 0


async def finish(peer: Peer, publish: Publish) -> None:
    await peer.send(Pubrec(publish.packet_id or 0))
    assert (await peer.expect(Pubrel)).packet_id == publish.packet_id
    await peer.send(Pubcomp(publish.packet_id or 0))
