"""The command line's client, against peers that are no homebot."""

import json
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import TypeVar

import anyio
import pytest
from anyio import to_thread
from anyio.abc import SocketAttribute, SocketStream
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from homebot.cli.door_client import DoorClient, ReceivedMessage, open_door
from homebot.cli.main import main
from homebot.cli.server_address import ServerAddress
from homebot.errors import HomebotError, LinkError, PeerError, RefusedError, ServiceTimeoutError, WireError

T = TypeVar("T")


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


def use(port: int, command: Callable[[DoorClient], T]) -> T:
    """Run *command* with a connection, as commands do: in a thread without an event loop."""
    with open_door(ServerAddress("127.0.0.1", port)) as door:
        return command(door)


def test_an_unknown_host_is_not_taken_for_a_homebot_that_does_not_run() -> None:
    with (
        pytest.raises(LinkError, match=r"on nosuch\.invalid:9090: the host name (is unknown|cannot be looked up)"),
        open_door(ServerAddress("nosuch.invalid", 9090)),
    ):
        pass


async def test_another_kind_of_server_is_named() -> None:
    async def greet(stream: SocketStream) -> None:
        async with stream:
            await stream.send(b"SSH-2.0-OpenSSH_9.2\r\n")

    listener = await anyio.create_tcp_listener(local_host="127.0.0.1")
    async with listener, anyio.create_task_group() as tasks:
        tasks.start_soon(listener.serve, greet)
        port = listener.listeners[0].extra(SocketAttribute.local_port)  # noqa: S610  # anyio's, not Django's
        with pytest.raises(LinkError, match=f"the server on 127.0.0.1:{port} is not a homebot"):
            await to_thread.run_sync(use, port, lambda _door: None)
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

    async with answering(answer) as port:
        with pytest.raises(error, match=problem):
            await to_thread.run_sync(use, port, lambda door: door.call("/x"))


@pytest.mark.parametrize("command", [["devices"], ["find", "lamp"], ["doctor"], ["topic", "list"]])
async def test_a_homebot_of_another_version_is_an_error_that_says_so(
    capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    values = {"success": True, "total": 1, "results": [{}], "devices": [{}], "endpoints": [{}]}

    def answer(_connection: ServerConnection, frame: str) -> list[str]:
        asked = json.loads(frame)
        return [json.dumps({"op": "service_response", "id": asked.get("id"), "result": True, "values": values})]

    async with answering(answer) as port:
        assert await to_thread.run_sync(main, ["--door", f"127.0.0.1:{port}", *command]) == 1
    assert "; is it of another version?" in capsys.readouterr().err


async def test_messages_that_come_while_something_else_is_awaited_are_kept() -> None:
    message = '{"op":"publish","topic":"/t","msg":{"data":1},"lost":2}'
    response = '{"op":"service_response","id":"call:1","result":true,"values":{}}'

    def answer(_connection: ServerConnection, frame: str) -> list[str]:
        return [message, response] if "call_service" in frame else []

    async with answering(answer) as port:
        assert await to_thread.run_sync(use, port, lambda door: (door.call("/x"), door.next())) == (
            {},
            ReceivedMessage("/t", {"data": 1}, 2),
        )


async def test_a_connection_that_ends_is_an_error() -> None:
    def leave(connection: ServerConnection, _frame: str) -> list[str]:
        connection.transport.abort()
        return []

    async with answering(leave) as port:
        with pytest.raises(
            LinkError, match="the connection to homebot ended: it was cut; homebot crashed, or changed the token"
        ):
            await to_thread.run_sync(use, port, lambda door: (door.settle(), door.settle()))


async def test_a_connection_that_ends_while_a_message_is_awaited_says_why() -> None:
    async def answer(connection: ServerConnection) -> None:
        await connection.recv()
        await connection.close(1001, "the house is on fire")

    async with serve(answer, "127.0.0.1", 0) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        with pytest.raises(LinkError, match="the connection to homebot ended: the house is on fire"):
            await to_thread.run_sync(use, port, lambda door: (door.subscribe("/t"), door.next()))


async def test_a_message_in_fragments_is_one_message() -> None:
    async def answer(connection: ServerConnection) -> None:
        await connection.recv()
        await connection.send(['{"op":"publish",', '"topic":"/t",', '"msg":{"data":"é"}}'])
        await connection.wait_closed()

    async with serve(answer, "127.0.0.1", 0) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        received = await to_thread.run_sync(use, port, lambda door: (door.subscribe("/t"), door.next())[1])
    assert received.message == {"data": "é"}


async def test_a_server_that_says_nothing_is_not_waited_for_without_end() -> None:
    async with answering(lambda _connection, _frame: []) as port:
        with pytest.raises(TimeoutError):
            await to_thread.run_sync(use, port, lambda door: door.next(0.05))
        with pytest.raises(ServiceTimeoutError, match="/x"):
            await to_thread.run_sync(use, port, lambda door: door.call("/x", timeout=0.05))
        assert await to_thread.run_sync(use, port, lambda door: [*door.until(0.05)]) == []


async def test_answers_that_come_in_another_order_reach_who_asked() -> None:
    asked: list[str] = []

    def answer(_connection: ServerConnection, frame: str) -> list[str]:
        call = json.loads(frame)
        assert abs(call["sent"] - time.time()) < 60
        assert call["patience"] == call["timeout"], "a link that hangs may not deliver it later"
        asked.append(call["id"])
        replies = [{"op": "service_response", "id": one, "result": True, "values": {"of": one}} for one in asked]
        return [json.dumps(one) for one in reversed(replies)] if len(asked) == 2 else []

    def both(door: DoorClient) -> tuple[object, object]:
        first, second = door.begin_call("/x"), door.begin_call("/x")
        return first(), second()

    async with answering(answer) as port:
        assert await to_thread.run_sync(use, port, both) == ({"of": "call:1"}, {"of": "call:2"})


@pytest.mark.parametrize(
    ("frame", "error"),
    [
        (
            {"op": "status", "level": "error", "id": "publishing on /t", "msg": "the right raw is missing; …"},
            RefusedError,
        ),
        (
            {"op": "service_response", "id": "call:1", "result": False, "values": "the right act is missing; …"},
            PeerError,
        ),
    ],
)
async def test_a_missing_right_is_told_with_how_to_show_a_token_that_has_it(
    frame: dict[str, object], error: type[HomebotError]
) -> None:
    async with answering(lambda _connection, _text: [json.dumps(frame)]) as port:
        with pytest.raises(error, match=r"then reload homebot \(`kill -HUP`\), and use --token-file FILE"):
            await to_thread.run_sync(use, port, lambda door: door.call("/s"))
