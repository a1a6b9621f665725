"""Damaged requests to homebot's directory of things: each is answered, or its connection closed."""

import asyncio
import random
import re

import pytest
from structlog.testing import capture_logs
from tests.bridges.thing_directory.conftest import ServedHouse, open_house
from tests.fuzz.conftest import Fuzz, Mutator

from homebot.bridges.thing_directory.http_server import BODY_WITHIN, IDLE_FOR, TAKES_WITHIN
from homebot.testing import VirtualTimeLoop

LONGEST = 2 * max(IDLE_FOR, BODY_WITHIN, TAKES_WITHIN)
"""Seconds after which a connection on which nothing comes is closed."""

THING = "urn:homebot:fedcba9876543210:hall_lamp"
HOST = "Host: 127.0.0.1\r\n"
TOKEN = "Authorization: Bearer let-me-in\r\n"
STATUS = re.compile(rb"^HTTP/1\.[01] (\d{3}) ", re.MULTILINE)
EXPECTED = frozenset({100, 200, 204, 304, 400, 401, 403, 404, 405, 413, 417, 429, 501, 503, 505})
REQUESTS = (
    f"GET /.well-known/wot HTTP/1.1\r\n{HOST}{TOKEN}\r\n",
    f"GET /things?offset=1&limit=1&sort_order=desc&format=collection HTTP/1.1\r\n{HOST}{TOKEN}\r\n",
    f"HEAD /things?token=let-me-in HTTP/1.1\r\n{HOST}Origin: http://localhost:3000\r\n\r\n",
    f'GET http://127.0.0.1/things/{THING} HTTP/1.1\r\n{HOST}{TOKEN}If-None-Match: W/"a", *\r\n\r\n',
    f"GET /things/{THING}/properties HTTP/1.0\r\n{HOST}{TOKEN}Connection: keep-alive\r\n\r\n",
    f"PUT /things/{THING}/properties/level HTTP/1.1\r\n{HOST}{TOKEN}Content-Length: 4\r\n\r\n40.5",
    f"PUT /things/{THING}/properties/on_off HTTP/1.1\r\n{HOST}{TOKEN}Transfer-Encoding: chunked\r\n\r\n"
    "2;a=b\r\ntr\r\n2\r\nue\r\n0\r\nX: y\r\n\r\n",
    f"PUT /things/{THING}/properties/level HTTP/1.1\r\n{HOST}{TOKEN}Expect: 100-continue\r\n"
    "Content-Length: 2\r\n\r\n40",
    f"PUT /things/{THING}/properties/level HTTP/1.1\r\n{HOST}{TOKEN}Content-Encoding: gzip\r\n"
    "Content-Length: 1\r\n\r\n9",
    f"POST /things HTTP/1.1\r\n{HOST}{TOKEN}Content-Type: application/td+json\r\nContent-Length: 2\r\n\r\n{{}}",
    f"GET /events/thing_updated?diff=true HTTP/1.1\r\n{HOST}{TOKEN}Last-Event-ID: 00-1\r\n\r\n",
    f"GET /things HTTP/1.1\r\n{HOST}{TOKEN}Upgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
)
PATHS = (
    "/",
    "//",
    "/things//",
    "*",
    "/things/%2e%2e/%ff%00",
    "/events/x",
    "http://[x/",
    "/things?limit=99999999999",
    "",
)
VERSIONS = ("HTTP/1.1", "HTTP/1.0", "HTTP/2.0", "HTTP/0.9", "http/1.1", "")


class Link(asyncio.Transport):
    """The transport of a connection, in memory: what the server wrote, and whether it closed."""

    def __init__(self, protocol: asyncio.Protocol) -> None:
        super().__init__({"peername": ("127.0.0.1", 40_000)})
        self.written = bytearray()
        self.is_open = True
        self._protocol = protocol
        protocol.connection_made(self)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        if self.is_open:
            self.written += data

    def is_closing(self) -> bool:
        return not self.is_open

    def close(self) -> None:
        if self.is_open:
            self.is_open = False
            asyncio.get_running_loop().call_soon(self._protocol.connection_lost, None)

    def abort(self) -> None:
        self.close()

    def pause_reading(self) -> None:
        """Go on: a client that sends too much is the business of other tests."""

    def resume_reading(self) -> None:
        """Go on."""

    def feed(self, data: bytes) -> None:
        if self.is_open:
            self._protocol.data_received(data)


def stream_of(mutator: Mutator) -> bytes:
    """Return some requests, most of them damaged."""
    rng = mutator.rng
    found = bytearray()
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        request = rng.choice(REQUESTS)
        if rng.random() < 0.1:
            method, path, version, rest = re.split(r" |\r\n", request, maxsplit=3)
            path, version = rng.choice((path, *PATHS)), rng.choice((version, *VERSIONS))
            request = f"{rng.choice((method, 'PATCH', 'CONNECT', 'é'))} {path} {version}\r\n{rest}"
        if rng.random() < 0.1:
            request = request.replace(TOKEN, rng.choice(("", "Authorization: Bearer x\r\n", HOST)))
        raw = request.encode()
        found += mutator.damaged_bytes(raw) if rng.random() < 0.5 else raw
    return bytes(found)


def pieces_of(rng: random.Random, stream: bytes) -> list[bytes]:
    cuts = sorted({rng.randrange(len(stream) + 1) for _ in range(rng.choice((0, 0, 1, 3, 20)))})
    return [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]


async def settled() -> None:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualTimeLoop)
    await loop.settled()


async def use(house: ServedHouse, pieces: list[bytes], *, waits: bool) -> bytes:
    """Send *pieces* on a connection, which the client closes where it does not wait; return what was answered."""
    link = Link(house.bridge._server())
    for piece in pieces:
        link.feed(piece)
        await settled()
    if waits:
        await asyncio.sleep(LONGEST)
        assert not link.is_open or b"text/event-stream" in link.written, "the connection stays open"
    link.close()
    await settled()
    assert not house.bridge._server.connections, "the server keeps a connection that is closed"
    return bytes(link.written)


@pytest.mark.virtual_time
async def test_what_any_client_sends_is_answered_or_its_connection_closed(fuzz: Fuzz) -> None:
    async with open_house() as open_to_all, open_house(token="let-me-in") as guarded:
        for mutator, rng in fuzz("thing_directory_server"):
            stream = stream_of(mutator)
            house = rng.choice((open_to_all, guarded))
            with capture_logs() as lines:
                written = await use(house, pieces_of(rng, stream), waits=rng.random() < 0.2)
                await use(open_to_all, [b"GET /things HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"], waits=False)
            assert {int(one) for one in STATUS.findall(written)} <= EXPECTED, stream
            assert not [one for one in lines if one["log_level"] == "error"], (stream, lines)
            assert not written or written.startswith(b"HTTP/1."), (stream, written[:100])
