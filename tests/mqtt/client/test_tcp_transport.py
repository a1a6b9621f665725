"""Connections by TCP and TLS, and what can be wrong with them."""

import asyncio
import concurrent.futures
import contextlib
import errno
import socket
import ssl
import threading
from collections.abc import AsyncIterator, Coroutine
from pathlib import Path
from typing import Any

import anyio
import pytest
import trustme
from hypothesis import given
from hypothesis import strategies as st
from tests.mqtt.client.conftest import ClientKind
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.client.tcp_transport import ReadAhead, TcpTransport, dial_tcp, socket_error
from homebot.mqtt.options import MqttOptions


class NoUser:
    """Expects nothing to come."""

    def data_received(self, data: bytes) -> None:
        pytest.fail(f"{data!r} came")

    def drained(self) -> None:
        pass

    def link_ended(self, reason: LinkError | RefusedError) -> None:
        pass


@pytest.fixture(scope="session")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an authority, and a server and a client certificate that it signed."""
    folder = tmp_path_factory.mktemp("certificates")
    authority = trustme.CA()
    authority.cert_pem.write_to_path(folder / "ca.pem")
    for name, identity in (("server", "127.0.0.1"), ("client", "client@example.org")):
        issued = authority.issue_cert(identity)
        issued.private_key_pem.write_to_path(folder / f"{name}.key")
        issued.cert_chain_pems[0].write_to_path(folder / f"{name}.pem")
    return folder


def server_context(certificates: Path, *, wants_client: bool = False) -> ssl.SSLContext:
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(certificates / "server.pem", certificates / "server.key")
    if wants_client:
        context.load_verify_locations(certificates / "ca.pem")
        context.verify_mode = ssl.CERT_REQUIRED
    return context


async def test_messages_go_over_tls(client_kind: ClientKind, certificates: Path) -> None:
    async with Broker(tls=server_context(certificates)) as broker:
        client = client_kind(MqttOptions.from_url(f"mqtts://127.0.0.1:{broker.port}", ca_file=certificates / "ca.pem"))
        async with client.connected():
            await client.subscribe(MqttSubscription("t"))
            await client.publish("t", bytes(100_000), qos=1)
            assert [len(message.payload) for message in await client.receive()] == [100_000]


async def test_a_client_certificate_opens_the_door(client_kind: ClientKind, certificates: Path) -> None:
    async with Broker(tls=server_context(certificates, wants_client=True)) as broker:
        options = MqttOptions.from_url(
            f"mqtts://127.0.0.1:{broker.port}",
            ca_file=certificates / "ca.pem",
            cert_file=certificates / "client.pem",
            key_file=certificates / "client.key",
        )
        async with client_kind(options).connected() as session:
            assert session.protocol == "5"


def shake_hands(listener: socket.socket, context: ssl.SSLContext) -> None:
    """Meet one client; what went wrong is for the client to tell."""
    raw, _ = listener.accept()
    raw.settimeout(5)
    with raw.dup() as kept:  # a socket closed with unread bytes would take the alert back
        with raw, contextlib.suppress(ssl.SSLError), context.wrap_socket(raw, server_side=True):
            pytest.fail("the handshake went well")
        with contextlib.suppress(ConnectionError):
            while kept.recv(1000):
                pass


async def test_without_a_client_certificate_a_strict_broker_refuses(
    client_kind: ClientKind, certificates: Path
) -> None:
    """TLS 1.3 tells it only after the handshake, in the place of the answer to CONNECT."""
    context = server_context(certificates, wants_client=True)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        options = MqttOptions.from_url(
            f"mqtts://127.0.0.1:{listener.getsockname()[1]}", ca_file=certificates / "ca.pem", protocol="5"
        )
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(anyio.to_thread.run_sync, shake_hands, listener, context)
            words = "TLS was refused: client certificate required; set cert_file"
            with pytest.raises(RefusedError, match=words):
                async with client_kind(options).connected():
                    pass


async def test_a_broker_whose_certificate_is_not_trusted_is_refused(
    client_kind: ClientKind, certificates: Path
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        options = MqttOptions.from_url(f"mqtts://127.0.0.1:{listener.getsockname()[1]}")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(anyio.to_thread.run_sync, shake_hands, listener, server_context(certificates))
            with pytest.raises(RefusedError, match="the broker's certificate was refused: "):
                async with client_kind(options).connected():
                    pass


async def test_tls_to_a_port_without_tls_asks_whether_it_is_the_port(
    client_kind: ClientKind, certificates: Path
) -> None:
    async with Broker() as broker:
        options = MqttOptions.from_url(f"mqtts://127.0.0.1:{broker.port}", ca_file=certificates / "ca.pem")
        with pytest.raises(LinkError, match=r"during the TLS handshake; is this its port for TLS, .*cert_file"):
            async with client_kind(options).connected():
                pass


async def test_a_dialled_socket_sends_small_packets_at_once() -> None:
    """With Nagle's algorithm an acknowledged publish may take 44 ms."""
    async with Broker() as broker:
        transport = await dial_tcp(MqttOptions(host="127.0.0.1", port=broker.port), NoUser())
        assert transport.socket is not None
        assert transport.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) != 0
        transport.close()
        await transport.wait_closed()


class CountingSocket(socket.socket):
    """Counts how often TCP was told to acknowledge at once."""

    acknowledged = 0

    def setsockopt(self, level: int, name: int, *value: Any) -> None:
        self.acknowledged += (level, name) == (socket.IPPROTO_TCP, socket.TCP_QUICKACK)
        super().setsockopt(level, name, *value)


class Reader(NoUser):
    """Takes whatever comes."""

    def data_received(self, data: bytes) -> None:
        pass


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="only Linux has TCP_QUICKACK")
@pytest.mark.virtual_time
async def test_a_burst_is_acknowledged_by_tcp_at_its_begin_and_once_in_a_millisecond() -> None:
    loop = asyncio.get_running_loop()
    with CountingSocket() as sock:
        transport = TcpTransport(Reader())
        transport.socket = sock
        await anyio.sleep(1)  # of virtual time
        counts = []
        for _ in range(1000):
            transport.get_buffer(-1)
            transport.buffer_updated(10)
            counts.append(sock.acknowledged)
        due = loop.create_future()
        loop.call_later(0.002, due.set_result, None)
        await due
        assert (counts[0], counts[-1], sock.acknowledged) == (1, 1, 2)


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost"])
async def test_a_port_where_nobody_listens_is_told_in_words(host: str) -> None:
    with pytest.raises(LinkError) as caught:
        await dial_tcp(MqttOptions(host=host, port=reserve_port()), NoUser())
    assert str(caught.value) == "nothing is listening there (connection refused): start it, or correct the address"


async def test_an_unknown_host_is_a_link_error() -> None:
    with pytest.raises(LinkError, match=r"the host name is unknown|the host name cannot be looked up now"):
        await dial_tcp(MqttOptions(host="no-such-host.invalid"), NoUser())


async def test_a_peer_that_never_shakes_hands_is_a_link_error_and_its_socket_is_closed(
    client_kind: ClientKind, certificates: Path
) -> None:
    async with silent_peer() as (port, _, closed):
        options = MqttOptions(host="127.0.0.1", port=port, tls=True, timeout=0.05, ca_file=certificates / "ca.pem")
        with pytest.raises(LinkError, match=r"no answer within 0\.05 s"):
            async with client_kind(options).connected():
                pass
        await closed.wait()


async def test_a_connect_that_is_cancelled_during_the_hand_shake_closes_its_socket(
    client_kind: ClientKind, certificates: Path
) -> None:
    async def connect() -> None:
        options = MqttOptions(host="127.0.0.1", port=port, tls=True, ca_file=certificates / "ca.pem")
        async with client_kind(options).connected():
            pass

    async with silent_peer() as (port, greeted, closed):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(connect)
            await greeted.wait()
            tasks.cancel_scope.cancel()
        await closed.wait()


async def test_so_it_does_where_its_thread_has_not_come_to_wait_for_the_hand_shake(
    certificates: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The thread of aiomqtt has the loop shake hands, and is stopped by the computer before it goes on."""
    goes_on, hand_over = threading.Event(), asyncio.run_coroutine_threadsafe

    def stopped(work: Coroutine[Any, Any, None], loop: asyncio.AbstractEventLoop) -> concurrent.futures.Future[None]:
        handed_over = hand_over(work, loop)
        goes_on.wait(PATIENCE)
        return handed_over

    async def connect() -> None:
        ca_file = certificates / "ca.pem"
        options = MqttOptions(host="127.0.0.1", port=port, tls=True, ca_file=ca_file, timeout=10 * PATIENCE)
        async with AiomqttClient(options).connected():
            pass

    monkeypatch.setattr(asyncio, "run_coroutine_threadsafe", stopped)
    async with silent_peer() as (port, greeted, closed):
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(connect)
                await greeted.wait()
                tasks.cancel_scope.cancel()
            with anyio.fail_after(PATIENCE):
                await closed.wait()
        finally:
            goes_on.set()


@contextlib.asynccontextmanager
async def silent_peer() -> AsyncIterator[tuple[int, anyio.Event, anyio.Event]]:
    """A port, what is set when somebody has said something there, and what when he has gone."""
    greeted, closed = anyio.Event(), anyio.Event()

    async def silent(stream: anyio.abc.SocketStream) -> None:
        async with stream:
            await stream.receive()
            greeted.set()
            with pytest.raises((anyio.EndOfStream, anyio.BrokenResourceError)):
                await drain(stream)
        closed.set()

    listener = await anyio.create_tcp_listener(local_host="127.0.0.1")
    async with listener, anyio.create_task_group() as tasks:
        tasks.start_soon(listener.serve, silent)
        yield listener.extra(anyio.abc.SocketAttribute.local_port), greeted, closed  # noqa: S610 - no database
        tasks.cancel_scope.cancel()


async def drain(stream: anyio.abc.SocketStream) -> None:
    while True:
        await stream.receive()


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (
            ConnectionRefusedError(errno.ECONNREFUSED, "Connect call failed ('127.0.0.1', 19511)"),
            "nothing is listening there (connection refused): start it, or correct the address",
        ),
        (ConnectionResetError(errno.ECONNRESET, "Connection reset by peer"), "the broker reset the connection"),
        (
            ssl.SSLEOFError(8, "EOF occurred in violation of protocol (_ssl.c:2427)"),
            "the broker closed the connection",
        ),
    ],
)
def test_the_link_is_to_blame_in_plain_words(error: OSError, words: str) -> None:
    found = socket_error(error)
    assert isinstance(found, LinkError)
    assert str(found) == words


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        ("TLSV13_ALERT_CERTIFICATE_REQUIRED", "client certificate required; set cert_file and key_file"),
        ("WRONG_VERSION_NUMBER", "the server there does not use TLS; is it the port for mqtt://?"),
        (
            "SSLV3_ALERT_HANDSHAKE_FAILURE",
            "handshake failure; does the broker require a client certificate (cert_file)?",
        ),
        ("TLSV1_ALERT_PROTOCOL_VERSION", "tlsv1 alert protocol version"),
    ],
)
def test_a_no_of_tls_is_a_no_with_a_hint(reason: str, words: str) -> None:
    error = ssl.SSLError(1, f"[SSL: {reason}] (_ssl.c:1006)")
    error.reason = reason
    found = socket_error(error)
    assert isinstance(found, RefusedError)
    assert found.reason == words


@given(st.lists(st.binary(max_size=50)), st.integers(1, 20))
def test_bytes_come_out_in_order_and_in_portions(chunks: list[bytes], portion: int) -> None:
    ahead = ReadAhead(portion, 1000)
    for chunk in chunks:
        ahead.put(chunk)
    taken = []
    while ahead.size:
        taken.append(ahead.pop())
    assert b"".join(taken) == b"".join(chunks)
    assert all(len(one) <= portion for one in taken)


def test_it_is_full_until_enough_is_taken() -> None:
    ahead = ReadAhead(4, 6)
    ahead.put(b"12345")
    assert not ahead.is_full
    ahead.put(b"6")
    assert ahead.is_full
    assert ahead.pop() == b"1234"
    assert not ahead.is_full


def test_nothing_is_left_of_nothing() -> None:
    assert ReadAhead(4, 6).pop() == b""
