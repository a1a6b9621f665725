"""The command line's client, against peers that are no homebot."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

import anyio
import pytest
from anyio.abc import SocketAttribute, SocketStream
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from homebot.cli.door_client import open_door
from homebot.errors import HomebotError, LinkError, PeerError, RefusedError, WireError


@asynccontextmanager
async def answering(answer: Callable[[ServerConnection, str], list[str]]) -> AsyncIterator[int]:
    """Serve a WebSocket that answers each frame as told; give its port."""

    async def handle(connection: ServerConnection) -> None:
        with suppress(ConnectionClosed):
            async for frame in connection:
                for text in answer(connection, str(frame)):
                    await connection.send(text)

    async with serve(handle, "127.0.0.1", 0, close_timeout=0.1) as server:
        yield next(iter(server.sockets)).getsockname()[1]


async def test_another_kind_of_server_is_named() -> None:
    async def greet(stream: SocketStream) -> None:
        async with stream:
            await stream.send(b"SSH-2.0-OpenSSH_9.2\r\n")

    listener = await anyio.create_tcp_listener(local_host="127.0.0.1")
    async with listener, anyio.create_task_group() as tasks:
        tasks.start_soon(listener.serve, greet)
        port = listener.listeners[0].extra(SocketAttribute.local_port)  # noqa: S610  # anyio's, not Django's
        with pytest.raises(LinkError, match=f"the server on 127.0.0.1:{port} is not a homebot"):
            async with open_door("127.0.0.1", port):
                pytest.fail("opened")
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize(
    ("reply", "error", "problem"),
    [
        ("nonsense", WireError, "invalid JSON: 'nonsense'"),
        ("[1]", WireError, "other than a rosbridge frame"),
        ('{"op":"service_response","id":"call:1","result":false,"values":"no luck"}', PeerError, "/x failed: no luck"),
        (
            '{"op":"status","level":"error","id":"publishing on /t","msg":"bad"}',
            RefusedError,
            "^publishing on /t was .*: bad",
        ),
        ('{"op":"status","level":"error","msg":"bad"}', RefusedError, "^a frame was refused: bad"),
    ],
)
async def test_a_strange_answer_is_an_error(reply: str, error: type[HomebotError], problem: str) -> None:
    def answer(_connection: ServerConnection, frame: str) -> list[str]:
        return [reply] if "call_service" in frame else []

    async with answering(answer) as port, open_door("127.0.0.1", port) as door:
        with pytest.raises(error, match=problem):
            await door.call("/x")


async def test_messages_that_come_while_something_else_is_awaited_are_kept() -> None:
    message = '{"op":"publish","topic":"/t","msg":{"data":1},"lost":2}'
    response = '{"op":"service_response","id":"call:1","result":true,"values":{}}'

    def answer(_connection: ServerConnection, frame: str) -> list[str]:
        return [message, response] if "call_service" in frame else []

    async with answering(answer) as port, open_door("127.0.0.1", port) as door:
        assert await door.call("/x") == {}
        delivery = await door.next()
    assert (delivery.topic, delivery.message, delivery.lost) == ("/t", {"data": 1}, 2)


async def test_a_connection_that_ends_is_an_error() -> None:
    def leave(connection: ServerConnection, _frame: str) -> list[str]:
        connection.transport.abort()
        return []

    async with answering(leave) as port, open_door("127.0.0.1", port) as door:
        with pytest.raises(LinkError, match="the connection to homebot ended"):
            await door.next()
