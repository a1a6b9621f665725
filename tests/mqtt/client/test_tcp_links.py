"""What a client by TCP does with the link, against a broker that plays a script."""

import asyncio
import gc
import logging
import socket
import struct
from collections.abc import Callable
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs
from tests.mqtt.client.conftest import ClientKind
from tests.mqtt.client.scripted_broker import MakeClient, Peer, broker, idle, linked

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.client import MqttClient
from homebot.mqtt.options import MqttOptions, MqttProtocol

# -- the link -------------------------------------------------------------------------------------------------


async def test_login_and_will_reach_the_broker(client_kind: ClientKind) -> None:
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
        await peer.expect(mqtt.Disconnect)

    async with broker(script) as port:
        options = MqttOptions.from_url(
            f"mqtt://anna:pw@127.0.0.1:{port}", client_id="hub", will=mqtt.Will("w", b"gone", 1, retain=True)
        )
        async with client_kind(options).connected() as session:
            assert session.protocol == "5"


@pytest.mark.parametrize(
    "refusal",
    [
        mqtt.encode(mqtt.Connack(reason=mqtt.ReasonCode.UNSUPPORTED_PROTOCOL_VERSION), mqtt.ProtocolVersion.V5),
        bytes.fromhex("20 02 00 01"),  # as MQTT 3.1.1 says it
        b"",  # no word at all
    ],
)
async def test_a_broker_that_does_not_speak_5_is_asked_with_3_1_1(make: MakeClient, refusal: bytes) -> None:
    async def deaf(peer: Peer) -> None:
        assert (await peer.expect(mqtt.Connect)).version is mqtt.ProtocolVersion.V5
        if refusal:
            await peer.send_raw(refusal)

    async def old(peer: Peer) -> None:
        assert (await peer.login()).version is mqtt.ProtocolVersion.V311
        await peer.expect(mqtt.Disconnect)

    with capture_logs() as lines:
        async with broker(deaf, old, old) as port:
            client = make(port)
            for _ in range(2):  # the second time without asking for 5
                async with client.connected() as session:
                    assert session.protocol == "3.1.1"
    said = [line["message"] for line in lines if line["event"] == "mqtt.fell_back"]
    assert said == [f"mqtt://127.0.0.1:{port} supports MQTT 3.1.1, not 5"]


@pytest.mark.parametrize(
    ("nonsense", "problem"),
    [
        (b"", r"the broker closed the connection instead of answering; is this a port for TLS \(mqtts://\)\?"),
        (b"\x15\x03\x01\x00\x02\x02\x46", r"the server there uses TLS; is the address mqtts://\?"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n" + bytes(100), "the server there is not an MQTT broker"),
        (b"\xff" * 20, "the server there is not an MQTT broker"),
    ],
)
async def test_who_speaks_no_version_at_all_is_not_called_old(make: MakeClient, nonsense: bytes, problem: str) -> None:
    async def strange(peer: Peer) -> None:
        await peer.expect(mqtt.Connect)
        if nonsense:
            await peer.send_raw(nonsense)

    with capture_logs() as lines:
        async with broker(strange, strange) as port:
            with pytest.raises(LinkError, match=f"^{problem}$"):
                async with make(port).connected():
                    pass
    assert [line for line in lines if line["event"] == "mqtt.fell_back"] == []


async def test_a_broker_that_cuts_the_connection_instead_of_answering_gets_a_hint(make: MakeClient) -> None:
    """Brokers do so where TLS, or a client certificate, is missing."""

    async def cut(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read(1)
        writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        writer.transport.abort()  # a reset, not a good-bye

    async with await asyncio.start_server(cut, "127.0.0.1", 0) as server:
        hint = r"(reset|closed) the connection instead of answering; is this a port for TLS \(mqtts://\)\?"
        with pytest.raises(LinkError, match=hint):
            async with make(server.sockets[0].getsockname()[1]).connected():
                pass


async def test_a_broker_that_spoke_5_before_is_not_asked_with_3_1_1_because_it_closed_once(make: MakeClient) -> None:
    async def restarting(peer: Peer) -> None:
        await peer.expect(mqtt.Connect)

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
        (mqtt.ReasonCode.BAD_USER_NAME_OR_PASSWORD, RefusedError),
        (mqtt.ReasonCode.NOT_AUTHORIZED, RefusedError),
        (mqtt.ReasonCode.SERVER_BUSY, LinkError),
    ],
)
async def test_a_login_is_refused_or_put_off_and_no_secret_is_told(
    client_kind: ClientKind, code: mqtt.ReasonCode, error: type[Exception]
) -> None:
    async def script(peer: Peer) -> None:
        await peer.expect(mqtt.Connect)
        await peer.send(mqtt.Connack(reason=code))

    async with broker(script) as port:
        options = MqttOptions.from_url(f"mqtt://anna:hunter2@127.0.0.1:{port}")
        with pytest.raises(error, match=code.name.lower().replace("_", " ")) as caught:
            async with client_kind(options).connected():
                pass
    chain: BaseException | None = caught.value
    while chain is not None:
        assert "hunter2" not in f"{chain!r} {chain.args}"
        chain = chain.__cause__ or chain.__context__


async def test_a_broker_that_does_not_answer_connect_is_a_link_error(
    make: MakeClient, pass_time: Callable[[float], None]
) -> None:
    async def script(peer: Peer) -> None:
        await peer.expect(mqtt.Connect)
        pass_time(20)
        await peer.closed()

    async with broker(script) as port:
        with pytest.raises(LinkError, match="no answer to CONNECT"):
            async with make(port, timeout=20).connected():
                pass


async def test_a_broker_that_says_nothing_to_5_is_asked_with_3_1_1_the_next_time(
    make: MakeClient, pass_time: Callable[[float], None]
) -> None:
    """As amqtt, which waits for more where it reads the properties of 5 as something else; others were only slow."""

    async def silent(peer: Peer) -> None:
        assert (await peer.expect(mqtt.Connect)).version is mqtt.ProtocolVersion.V5
        pass_time(20)
        await peer.closed()

    async def old(peer: Peer) -> None:
        assert (await peer.login()).version is mqtt.ProtocolVersion.V311
        await peer.expect(mqtt.Disconnect)

    async def new(peer: Peer) -> None:
        assert (await peer.login()).version is mqtt.ProtocolVersion.V5
        await peer.expect(mqtt.Disconnect)

    with capture_logs() as lines:
        async with broker(silent, old, new) as port:
            client = make(port, timeout=20)
            with pytest.raises(LinkError, match="no answer to CONNECT"):
                async with client.connected():
                    pass
            for version in ("3.1.1", "5"):
                async with client.connected() as session:
                    assert session.protocol == version
    said = [line["message"] for line in lines if line["event"] == "mqtt.fell_back"]
    assert said == [f"mqtt://127.0.0.1:{port} says nothing to MQTT 5, and speaks 3.1.1"]


@pytest.mark.parametrize("refusal", [bytes.fromhex("20 02 00 01"), b""])
async def test_a_slow_broker_that_speaks_only_5_is_asked_with_5_at_once_again(
    make: MakeClient, pass_time: Callable[[float], None], refusal: bytes
) -> None:
    """After a refusal the next try is later than after a lost link, and it was only slow."""

    async def silent(peer: Peer) -> None:
        await peer.expect(mqtt.Connect)
        pass_time(20)
        await peer.closed()

    async def only_5(peer: Peer) -> None:
        assert (await peer.expect(mqtt.Connect)).version is mqtt.ProtocolVersion.V311
        if refusal:
            await peer.send_raw(refusal)

    async def new(peer: Peer) -> None:
        assert (await peer.login()).version is mqtt.ProtocolVersion.V5
        await peer.expect(mqtt.Disconnect)

    with capture_logs() as lines:
        async with broker(silent, only_5, new) as port:
            client = make(port, timeout=20)
            with pytest.raises(LinkError, match="no answer to CONNECT"):
                async with client.connected():
                    pass
            async with client.connected() as session:
                assert session.protocol == "5"
    assert [line for line in lines if line["event"] == "mqtt.fell_back"] == []


async def test_a_cancelled_connect_leaves_nothing_behind(make: MakeClient) -> None:
    """The library keeps its lock, a task and the socket, and cannot be used again."""
    asked = anyio.Event()

    async def silent(peer: Peer) -> None:
        await peer.expect(mqtt.Connect)
        asked.set()
        await peer.closed()

    async def connect(client: MqttClient) -> None:
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


async def test_a_session_is_taken_up_again_by_a_new_process_and_by_the_next_link(make: MakeClient) -> None:
    """The library's default cleans the session with the first CONNECT of each client object."""

    async def script(peer: Peer) -> None:
        connect = await peer.login(session_present=True)
        assert not connect.clean_start
        assert connect.properties.session_expiry_interval == 3600
        await peer.expect(mqtt.Disconnect)

    async with broker(script, script) as port:
        client = make(port, session_expiry=3600, client_id="hub")
        for _ in range(2):
            async with client.connected() as session:
                assert session.resumed


@pytest.mark.parametrize("version", ["5", "3.1.1"])
async def test_without_session_expiry_every_link_starts_clean(make: MakeClient, version: MqttProtocol) -> None:
    async def script(peer: Peer) -> None:
        assert (await peer.login()).clean_start
        await peer.expect(mqtt.Disconnect)

    async with broker(script, script) as port:
        client = make(port, protocol=version)
        for _ in range(2):
            async with client.connected():
                pass


async def test_an_open_qos_2_publish_is_brought_to_its_end_and_its_identifier_is_not_used_again(
    make_native: MakeClient,
) -> None:
    """A new client object would number from the start; the broker then swallows the next message as a repetition."""
    numbers: list[int | None] = []

    async def first(peer: Peer) -> None:
        await peer.login()
        numbers.append((await peer.expect(mqtt.Publish)).packet_id)

    async def second(peer: Peer) -> None:
        await peer.login(session_present=True)
        again, other = await peer.expect(mqtt.Publish), await peer.expect(mqtt.Publish)
        assert (again.payload, again.dup, again.packet_id) == (b"one", True, numbers[0])
        numbers.append(other.packet_id)
        await finish(peer, again)
        await finish(peer, other)
        await peer.expect(mqtt.Disconnect)

    async with broker(first, second) as port:
        client = make_native(port, session_expiry=60)
        async with client.connected():
            with pytest.raises(LinkError):
                await client.publish("t", b"one", qos=2)
        async with client.connected():
            await client.publish("t", b"two", qos=2)
    assert numbers[0] != numbers[1]


@pytest.mark.parametrize(("qos", "session_present"), [(1, True), (2, False)])
async def test_a_failed_publish_of_qos_1_or_into_a_lost_session_does_not_fire_on_the_next_link(
    make: MakeClient, qos: int, *, session_present: bool
) -> None:
    async def first(peer: Peer) -> None:
        await peer.login()
        await peer.expect(mqtt.Publish)

    async def second(peer: Peer) -> None:
        await peer.login(session_present=session_present)
        assert (await peer.expect(mqtt.Publish)).payload == b"new"
        await peer.expect(mqtt.Disconnect)

    async with broker(first, second) as port:
        client = make(port, session_expiry=60)
        async with client.connected():
            with pytest.raises(LinkError):
                await client.publish("t", b"old", qos=qos)
        async with client.connected():
            await client.publish("t", b"new")


async def test_a_redelivered_message_is_acknowledged_on_its_own_link(make: MakeClient) -> None:
    async def first(peer: Peer) -> None:
        await peer.login()
        await peer.send(mqtt.Publish("t", b"x", 1, packet_id=7))

    async def second(peer: Peer) -> None:
        await peer.login(session_present=True)
        await peer.send(mqtt.Publish("t", b"x", 1, dup=True, packet_id=7))
        assert (await peer.expect(mqtt.Publish)).topic == "marker"
        assert (await peer.expect(mqtt.Puback)).packet_id == 7
        assert isinstance(await peer.next(), mqtt.Disconnect)

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


async def test_a_drop_with_unsent_data_makes_no_noise(make: MakeClient, caplog: pytest.LogCaptureFixture) -> None:
    """The library leaves bad file descriptors and futures that nobody reads to the loop's exception handler."""
    noise: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: noise.append(context))

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(mqtt.Publish)

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
        (mqtt.ReasonCode.SESSION_TAKEN_OVER, RefusedError),
        (mqtt.ReasonCode.ADMINISTRATIVE_ACTION, RefusedError),
        (mqtt.ReasonCode.SERVER_SHUTTING_DOWN, LinkError),
    ],
)
async def test_the_brokers_good_bye_tells_why(make: MakeClient, code: mqtt.ReasonCode, error: type[Exception]) -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send(mqtt.Disconnect(code))
        await peer.closed()

    async with broker(script) as port, (client := make(port)).connected():
        reason = await client.wait_lost()
    assert isinstance(reason, error)
    assert code.name.lower().replace("_", " ") in str(reason)


async def test_a_client_has_one_link_at_a_time(make: MakeClient) -> None:
    async with linked(make) as (client, _):
        with pytest.raises(UsageError, match="already connected"):
            async with client.connected():
                pass


async def test_without_a_link_there_is_nothing_to_do(make: MakeClient) -> None:
    client = make(1)
    with pytest.raises(LinkError, match="not connected"):
        await client.publish("t")
    with pytest.raises(LinkError, match="not connected"):
        await client.receive()
    client.ack([])


async def fail_to_publish(client: MqttClient, qos: int) -> None:
    try:
        await client.publish("t", bytes(50_000), qos=qos)
    except LinkError:
        return
    assert qos == 0


async def finish(peer: Peer, publish: mqtt.Publish) -> None:
    await peer.send(mqtt.Pubrec(publish.packet_id or 0))
    assert (await peer.expect(mqtt.Pubrel)).packet_id == publish.packet_id
    await peer.send(mqtt.Pubcomp(publish.packet_id or 0))
