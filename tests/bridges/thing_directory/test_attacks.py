"""Clients that break the rules of HTTP, or ask too much: they are refused, and the others are served."""

from contextlib import AsyncExitStack, suppress

import anyio
import pytest
from structlog.testing import capture_logs
from tests.bridges.thing_directory.conftest import OpenHouse, ServedHouse
from tests.patience import PATIENCE

from homebot.devices.health import HealthRequest

HOST = b"Host: 127.0.0.1\r\n"


async def answer_to(port: int, request: bytes) -> bytes:
    """Return the beginning of the answer to *request*; empty where the connection is cut."""
    async with await anyio.connect_tcp("127.0.0.1", port) as stream:
        with anyio.fail_after(PATIENCE):
            try:
                await stream.send(request)
                return await stream.receive(200)
            except (anyio.EndOfStream, anyio.BrokenResourceError):
                return b""


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (b"\x00\xff\x01\r\n\r\n", (b" 400 ",)),
        (b"GET /things HTTP/1.1\r\n\r\n", (b" 400 ", b" 403 ")),
        (b"GET /things HTTP/1.1\r\n" + HOST + HOST + b"\r\n", (b" 400 ", b" 403 ")),
        (b"GET /things HTTP/1.1\r\n" + HOST + b"X: " + b"a" * 1_000_000 + b"\r\n\r\n", (b" 400 ", b"")),
        (b"GET //[ HTTP/1.1\r\n" + HOST + b"\r\n", (b" 404 ", b" 400 ")),
        (b"GET /things HTTP/1.1\r\nHost: 127.0.0.1?\xb5\r\n\r\n", (b" 403 ",)),
        (b"CONNECT / HTTP/2.0\r\n" + HOST + b"\r\n", (b"HTTP/1.1 505 ",)),
        (b"GET /things/%ff%00 HTTP/1.1\r\n" + HOST + b"\r\n", (b" 404 ",)),
        (b"GET http://[x/ HTTP/1.1\r\n" + HOST + b"\r\n", (b" 404 ", b" 400 ")),
        (
            b"PUT /things/x/properties/y HTTP/1.1\r\n"
            + HOST
            + b"Transfer-Encoding: chunked\r\n\r\n20000\r\n"
            + b"a" * 0x20000,
            (b" 413 ", b""),
        ),
        (b"PUT /things/x/properties/y HTTP/1.1\r\n" + HOST + b"Content-Length: 99999999999\r\n\r\n", (b" 413 ",)),
    ],
)
async def test_an_invalid_request_is_refused_and_the_next_one_is_answered(
    house: ServedHouse, request_: bytes, status: tuple[bytes, ...]
) -> None:
    answer = await answer_to(house.bridge.port, request_)
    assert any(one in answer if one else not answer for one in status), answer
    assert len(await house.things(2)) == 2


@pytest.mark.parametrize(
    "request_",
    [
        b"GET /things HTTP/1.1\r\nAuthorization : Bearer hunter2\r\n\r\n",
        b"GET /things?token=hunter2 HTTP/9.7\r\n\r\n",
        b"GET http://here:99999/things?token=hunter2 HTTP/1.1\r\nHost: here\r\n\r\n",
        b"GET /things?token=hunter2" + b"a" * 9_000 + b" HTTP/1.1\r\n\r\n",
    ],
)
async def test_an_invalid_request_is_logged_without_the_token_in_it(house: ServedHouse, request_: bytes) -> None:
    with capture_logs() as logs:
        await answer_to(house.bridge.port, request_)
    assert [one["event"] for one in logs] == ["thing_directory.invalid_http"]
    assert "hunter2" not in str(logs)


async def test_connections_beyond_the_limit_are_refused_until_others_close(served_house: OpenHouse) -> None:
    async with served_house(max_clients=5) as house:
        await house.things(2)
        opened = []
        for _ in range(20):
            opened.append(await anyio.connect_tcp("127.0.0.1", house.bridge.port))
            with suppress(anyio.BrokenResourceError, anyio.EndOfStream):
                await opened[-1].send(b"GET /things HTTP/1.1\r\n" + HOST + b"\r\n")
                await opened[-1].receive()
        assert b" 503 " in await answer_to(house.bridge.port, b"GET /things HTTP/1.1\r\n" + HOST + b"\r\n")
        for stream in opened:
            await stream.aclose()
        assert len(await house.things(2)) == 2
        counts = {one.name: one.count for one in house.bridge.health(HealthRequest()).counts}
        assert counts["turned_away"] >= 15


async def test_connections_without_a_request_or_with_a_wrong_token_keep_no_client_out(served_house: OpenHouse) -> None:
    async with served_house(max_clients=5, token="right") as house, AsyncExitStack() as opened:
        right = b"GET /things HTTP/1.1\r\n" + HOST + b"Authorization: Bearer right\r\n\r\n"
        preflight = b"OPTIONS /things HTTP/1.1\r\n" + HOST + b"Access-Control-Request-Method: GET\r\n\r\n"
        wrong = b"GET /things HTTP/1.1\r\n" + HOST + b"\r\n"
        for request in (b"", b"GET /things HTTP/1.1\r\nHost: 127", wrong, preflight):
            for _ in range(5):
                stream = await opened.enter_async_context(await anyio.connect_tcp("127.0.0.1", house.bridge.port))
                await stream.send(request)
                if request.endswith(b"\r\n\r\n"):
                    await stream.receive()
            assert b" 200 " in await answer_to(house.bridge.port, right), request


async def test_a_client_that_floods_and_reads_nothing_leaves_the_others_alone(served_house: OpenHouse) -> None:
    async with (
        served_house() as house,
        await anyio.connect_tcp("127.0.0.1", house.bridge.port) as stream,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(stream.send, (b"GET /things HTTP/1.1\r\n" + HOST + b"\r\n") * 20_000)
        for _ in range(20):
            assert len(await house.things(2)) == 2
        tasks.cancel_scope.cancel()
