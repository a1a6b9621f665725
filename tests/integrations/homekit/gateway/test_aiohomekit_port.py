"""The library's errors become homebot's, and none shows a code; other tests pair and talk to HAP-python."""

import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import anyio
import anyio.abc
import pytest
from anyio.abc import SocketStream
from tests.one_task import in_one_task
from tests.patience import PATIENCE, until

from homebot.errors import LinkError, PeerError
from homebot.integrations.homekit.gateway.aiohomekit_port import AiohomekitPort
from homebot.integrations.homekit.gateway.port import FoundAccessory

CODE = "031-45-154"
KEYS = {
    "AccessoryPairingID": "AA:BB:CC:DD:EE:01",
    "AccessoryLTPK": "00" * 32,
    "iOSPairingId": "0638753c-97d9-41a9-824f-3b176988bcb1",
    "iOSDeviceLTSK": "11" * 32,
    "iOSDeviceLTPK": "22" * 32,
}


@asynccontextmanager
async def peer(answer: bytes) -> AsyncIterator[FoundAccessory]:
    """A server that answers each request so, and then closes the connection."""

    async def serve(stream: SocketStream) -> None:
        async with stream:
            await stream.receive()
            await stream.send(answer)

    listener = await anyio.create_tcp_listener(local_host="127.0.0.1", local_port=0)
    port = listener.extra(anyio.abc.SocketAttribute.local_port)  # noqa: S610 - no Django
    async with listener, anyio.create_task_group() as tasks:
        tasks.start_soon(listener.serve, serve)
        yield FoundAccessory("AA:BB:CC:DD:EE:01", "Hall", "127.0.0.1", port, is_paired=False)
        tasks.cancel_scope.cancel()


async def attempt(found: FoundAccessory, *, pairs: bool) -> None:
    port = AiohomekitPort(connects_within=PATIENCE)
    if pairs:
        await port.pair(found, CODE)
    else:
        async with port.connected(found, KEYS, print):
            pytest.fail("it connected")


@pytest.fixture
async def _in_time(caplog: pytest.LogCaptureFixture, pass_time: Callable[[float], None]) -> AsyncIterator[None]:
    """The time to connect is over once the library has tried it for the first time."""
    caplog.set_level(logging.DEBUG)

    async def watch() -> None:
        await until(lambda: "Connecting to accessory failed" in caplog.text)
        pass_time(PATIENCE)

    @asynccontextmanager
    async def watching() -> AsyncIterator[None]:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(watch)
            yield
            tasks.cancel_scope.cancel()

    async with in_one_task(watching()):
        yield


@pytest.mark.usefixtures("_in_time")
@pytest.mark.parametrize("pairs", [True, False])
@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (b"HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabc", PeerError),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 6\r\n\r\n\x06\x01\x02\x07\x01\x02", PeerError),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nabc", LinkError),
        (b"", LinkError),
    ],
    ids=["nonsense", "refused", "cut", "closed"],
)  # fmt: skip
async def test_a_peer_that_does_not_play_along_is_an_error_of_ours(
    answer: bytes, error: type[Exception], caplog: pytest.LogCaptureFixture, *, pairs: bool
) -> None:
    async with peer(answer) as found:
        with pytest.raises(error, match="Hall") as caught:
            await attempt(found, pairs=pairs)
    assert CODE not in str(caught.value) + caplog.text
    assert "11" * 32 not in str(caught.value) + caplog.text


@pytest.mark.usefixtures("_in_time")
@pytest.mark.parametrize("pairs", [True, False])
async def test_an_accessory_that_is_not_there_cannot_be_reached(*, pairs: bool) -> None:
    async with peer(b"") as found:
        pass
    with pytest.raises(LinkError, match="Hall cannot be reached"):
        await attempt(found, pairs=pairs)


@pytest.mark.parametrize("service_type", ["_hap._tcp", "_hap._udp"])
async def test_keys_that_are_none_are_an_error_of_ours(service_type: str) -> None:
    found = FoundAccessory("AA:BB:CC:DD:EE:01", "Hall", "127.0.0.1", 1, service_type)
    with pytest.raises(PeerError, match="Hall"):
        async with AiohomekitPort().connected(found, {}, print):
            pytest.fail("it connected")
