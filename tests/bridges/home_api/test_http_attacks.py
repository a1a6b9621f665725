"""Attacks on the HTTP API: none gets in, each is bounded, and an honest client is answered all the while."""

import json
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import anyio.lowlevel
import pytest
from anyio.abc import SocketStream
from structlog.testing import capture_logs
from tests.bridges.conftest import House
from tests.patience import PATIENCE

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.devices.names import LIST_DEVICES
from homebot.devices.services import ListDevices, ListDevicesRequest, ListDevicesResponse

HOST = "Host: 127.0.0.1"
GET = f"GET /api/home HTTP/1.1\r\n{HOST}\r\n"
POST = f"POST /api/command HTTP/1.1\r\n{HOST}\r\n"
JSON = "Content-Type: application/json\r\n"


@asynccontextmanager
async def sent(house: Any, text: str) -> AsyncIterator[SocketStream]:
    async with await anyio.connect_tcp("127.0.0.1", house.server.port) as stream:
        await stream.send(text.encode())
        yield stream


async def received(stream: SocketStream) -> str:
    """All that comes until the door ends the connection."""
    parts = []
    with anyio.fail_after(PATIENCE):
        try:
            while True:
                parts.append(await stream.receive())
        except (anyio.EndOfStream, anyio.BrokenResourceError):
            return b"".join(parts).decode()


async def answer(house: Any, text: str) -> tuple[int, str]:
    async with sent(house, text) as stream:
        head = await received(stream)
    return (int(head.split()[1]) if head else 0), head


def posted(values: object, *headers: str) -> str:
    body = json.dumps(values)
    lines = "".join([f"{one}\r\n" for one in headers])
    return f"{POST}{JSON}{lines}Content-Length: {len(body)}\r\n\r\n{body}"


CHUNKED = f"{POST}{JSON}Transfer-Encoding: chunked\r\n\r\n"
LAMP_ON = {"device": "lamp", "do": "on"}


@pytest.mark.parametrize(
    "header",
    [
        "Origin: http://evil.example",
        "Origin: http://127.0.0.1:3000",
        "Origin: http://localhost:3000",
        "Origin: null",
        "Sec-Fetch-Site: same-site",
        "Sec-Fetch-Site: cross-site",
        "Host: evil.example",
    ],
)
async def test_a_page_of_another_server_neither_reads_nor_commands(house: House, header: str) -> None:
    assert (await answer(house, f"{GET}{header}\r\n\r\n"))[0] == 403
    assert (await answer(house, posted(LAMP_ON, header)))[0] in {400, 403}


async def test_an_invalid_request_is_logged_without_the_token_in_it(house: House) -> None:
    with capture_logs() as logs:
        assert (await answer(house, f"{POST}Authorization : Bearer hunter2\r\n\r\n"))[0] == 400
    assert ["illegal header line" in one["message"] for one in logs] == [True]
    assert "hunter2" not in str(logs)


@pytest.mark.parametrize(
    ("request_text", "status"),
    [
        (f"{GET}Content-Length: 2\r\n\r\nhi", 400),
        (f"{GET}Content-Length: 0\r\n\r\n", 503),
        (f"{GET}Transfer-Encoding: chunked\r\n\r\n2\r\nhi\r\n0\r\n\r\n", 400),
        (f"{GET}X: {'x' * 20_000}", 431),
        (f"{POST}Content-Type: text/plain\r\nContent-Length: 2\r\n\r\n{{}}", 415),
        (f"{POST}Content-Length: 2\r\n\r\n{{}}", 415),
        (f"{POST}{JSON}Content-Length: 4\r\n\r\n[[[[", 400),
        (f"{POST}{JSON}Content-Length: 70000\r\n\r\n{'x' * 70000}", 400),
        (f"{POST}{JSON}Content-Length: 2\r\nContent-Length: 3\r\n\r\n{{}} ", 400),
        (f"{POST}{JSON}Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n{{}}\r\n", 400),
        (f"{CHUNKED}8000\r\n{'x' * 0x8000}\r\n8001\r\n{'x' * 0x8001}", 400),
        (f"POST /api/command HTTP/1.1\r\n{HOST}\r\nX: {'x' * 20_000}", 400),
        (f"POST / HTTP/1.1\r\n{HOST}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nContent-Length: 0\r\n\r\n", 405),
        (f"DELETE /api/home HTTP/1.1\r\n{HOST}\r\n\r\n", 405),
        ("POST /api/command HTTP/1.1\r\n\r\n", 400),
        ("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 403),
        (posted(LAMP_ON), 503),  # there is no directory in this house: it came through
        (f"{GET}\r\n", 503),
    ],
)
async def test_a_request_is_what_it_should_be_or_is_refused(house: House, request_text: str, status: int) -> None:
    assert (await answer(house, request_text))[0] == status


@pytest.mark.parametrize("first", [f"{GET}\r\n", posted(LAMP_ON)])
@pytest.mark.parametrize("second", [f"{GET}\r\n", posted(LAMP_ON), "GET / HTTP/1.1\r\n\r\n", "x" * 100_000])
async def test_a_request_that_another_follows_at_once_is_answered(house: House, first: str, second: str) -> None:
    """Pipelining; the connection ends after the first answer, as that says."""
    _, head = await answer(house, f"{first}{second}")
    assert head.startswith("HTTP/1.1 503 ")
    assert (head.count("HTTP/1.1"), "\r\nConnection: close\r\n" in head) == (1, True)


async def test_another_method_is_answered_with_the_one_that_there_is(open_house: Any) -> None:
    """Source: RFC 9110, 15.5.6: such an answer has the header `Allow`."""
    async with open_house() as house:
        _, head = await answer(house, f"{GET.replace('/api/home', '/api/command')}\r\n")
    assert "\r\nAllow: POST\r\n" in head


async def test_head_is_answered_like_get_without_the_body(house: House) -> None:
    """Source: RFC 9110, 9.3.2."""
    _, found = await answer(house, f"{GET}\r\n")
    _, head = await answer(house, f"HEAD{GET.removeprefix('GET')}\r\n")
    assert head == found.partition("\r\n\r\n")[0] + "\r\n\r\n"


async def test_a_get_with_fields_in_its_body_is_told_where_they_belong(house: House) -> None:
    """`requests.get(url, json=…)` sends the body after the head."""
    async with sent(house, f"{GET}Content-Length: 14\r\n\r\n") as stream:
        await stream.send(b'{"q": "light"}')
        assert "fields of GET belong in the address" in await received(stream)


async def test_a_body_that_is_too_long_is_told_the_limit(open_house: Any) -> None:
    async with open_house() as house:
        _, told = await answer(house, f"{CHUNKED}10001\r\n{'x' * 0x10001}\r\n")
    assert told.endswith("the body of an HTTP request has more than 65,536 bytes\n")


async def test_a_request_comes_in_time_or_not_at_all(open_house: Any) -> None:
    async with open_house(open_timeout=0.3) as house, AsyncExitStack() as slow:
        begun = (
            GET[:2],
            GET,
            POST,
            f"{POST}{JSON}Content-Length: 9\r\n\r\n{{",
            f"{CHUNKED}1\r\n",
        )
        streams = [await slow.enter_async_context(sent(house, one)) for one in begun]
        assert [await received(one) for one in streams] == [""] * len(begun)


async def test_a_body_is_asked_for_where_the_client_waits_for_that(house: House) -> None:
    head, _, body = posted(LAMP_ON, "Expect: 100-continue").partition("\r\n\r\n")
    async with sent(house, f"{head}\r\n\r\n") as stream:
        with anyio.fail_after(PATIENCE):
            assert (await stream.receive()).startswith(b"HTTP/1.1 100 ")
        await stream.send(body.encode())
        assert (await received(stream)).startswith("HTTP/1.1 503 ")


async def test_a_thousand_connections_are_bounded_and_an_honest_client_comes_through(house: House) -> None:
    waiting: list[SocketStream] = []
    for number in range(1000):
        stream = await anyio.connect_tcp("127.0.0.1", house.server.port)
        await stream.send((POST, GET, "P")[number % 3].encode())
        waiting.append(stream)
        if len(waiting) > 200:
            await waiting.pop(0).aclose()
        assert len(list(house.server._pending)) <= 64
    assert (await answer(house, f"{GET}\r\n"))[0] == 503
    for stream in waiting:
        await stream.aclose()


async def test_requests_count_as_clients_until_they_are_answered_or_left(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_clients=2)) as house:
        is_open = anyio.Event()

        async def late(_: ListDevicesRequest) -> ListDevicesResponse:
            await is_open.wait()
            return ListDevicesResponse(success=True)

        house.node("directory").create_service(ListDevices, LIST_DEVICES, late)
        async with sent(house, f"{GET}\r\n") as first:
            async with sent(house, f"{GET}\r\n"):
                await until_count(house, 2)
                await first.send(f"{GET}\r\n".encode())  # which is not read
                assert (await answer(house, f"{GET}\r\n"))[0] == 503
            await until_count(house, 1)
            is_open.set()
            assert '"devices":0' in await received(first)
        await until_count(house, 0)


async def until_count(house: Any, count: int) -> None:
    with anyio.fail_after(PATIENCE):
        while house.server.client_count != count:
            await anyio.lowlevel.checkpoint()


async def test_a_stopped_door_gives_up_its_requests(open_house: Any) -> None:
    with anyio.fail_after(PATIENCE):
        async with open_house() as house:
            house.node("directory").create_service(ListDevices, LIST_DEVICES, lambda _: anyio.sleep_forever())
            stream = await anyio.connect_tcp("127.0.0.1", house.server.port)
            await stream.send(f"{GET}\r\n".encode())
            await until_count(house, 1)
        await stream.aclose()
