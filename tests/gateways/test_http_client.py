import asyncio
import base64
import hashlib
import re
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import AsyncExitStack, contextmanager

import anyio
import pytest
import trustme
from aiohttp import WSMsgType, web
from pydantic import SecretStr
from tests.gateways.http_servers import Handler, serving
from tests.patience import PATIENCE
from tests.turns import Turns, longest_turn

from homebot.errors import HomebotError, LinkError, RefusedError, WireError
from homebot.gateways.event_stream import ServerEvent
from homebot.gateways.http_address import http_origin
from homebot.gateways.http_client import HttpClient
from homebot.gateways.http_streams import WebSocket
from homebot.gateways.password_settings import HttpLogin

pytestmark = pytest.mark.slow

PASSWORD = "correct horse"


def answering(status: int = 200, **response: object) -> Handler:
    async def handle(request: web.Request) -> web.Response:
        del request
        return web.Response(status=status, **response)  # type: ignore[arg-type]

    return handle


@contextmanager
def flooding(frame: bytes) -> Iterator[str]:
    """Serve one WebSocket that sends *frame* as fast as it goes, in a process of its own; yield its address."""
    program = """
import base64, hashlib, re, socket, sys
server = socket.create_server(("127.0.0.1", 0))
print(server.getsockname()[1], flush=True)
peer, _ = server.accept()
key = re.search(rb"(?i)sec-websocket-key: (\\S+)", peer.recv(4096))[1] + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
accepted = base64.b64encode(hashlib.sha1(key).digest())
peer.sendall(b"HTTP/1.1 101 Switching Protocols\\r\\nUpgrade: websocket\\r\\nConnection: Upgrade\\r\\n")
peer.sendall(b"Sec-WebSocket-Accept: " + accepted + b"\\r\\n\\r\\n")
while True:
    peer.sendall(bytes.fromhex(sys.argv[1]) * 50_000)
"""
    with subprocess.Popen(
        [sys.executable, "-c", program, frame.hex()], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as server:
        assert server.stdout is not None
        try:
            yield f"ws://127.0.0.1:{server.stdout.readline().strip()}/"
        finally:
            server.kill()


class TestRequests:
    async def test_an_answer_has_its_status_type_fields_and_body(self) -> None:
        headers = {"Content-Type": "application/TD+json; charset=utf-8", "Link": "</things?offset=9>; rel=next"}
        async with (
            serving(answering(headers=headers, body=b'{"id": "urn:x"}')) as url,
            HttpClient(guard=None) as client,
        ):
            answer = await client.get(f"{url}/things")
        assert (answer.status, answer.content_type) == (200, "application/td+json")
        assert answer.headers["link"] == "</things?offset=9>; rel=next"
        assert answer.json() == {"id": "urn:x"}

    @pytest.mark.parametrize("method", ["PUT", "POST"])
    async def test_json_is_sent_and_the_answer_read(self, method: str) -> None:
        async def handle(request: web.Request) -> web.Response:
            assert (request.method, request.content_type) == (method, "application/json")
            return web.json_response({"got": await request.json()})

        async with serving(handle) as url, HttpClient(guard=None) as client:
            assert await client.send_json(method, f"{url}/x", {"on": True}) == {"got": {"on": True}}

    async def test_an_empty_answer_is_none(self) -> None:
        async with serving(answering(204)) as url, HttpClient(guard=None) as client:
            assert await client.send_json("PUT", url, True) is None

    @pytest.mark.parametrize("status", [400, 401, 403, 404, 405, 409, 500, 501, 304])
    async def test_a_status_that_says_no_is_refused_with_that_code(self, status: int) -> None:
        async with serving(answering(status)) as url, HttpClient(guard=None) as client:
            with pytest.raises(RefusedError, match=str(status)) as caught:
                await client.get(url)
        assert caught.value.code == status

    @pytest.mark.parametrize("status", [408, 425, 429, 502, 503, 504])
    async def test_a_status_that_says_later_is_a_lost_link(self, status: int) -> None:
        async with serving(answering(status)) as url, HttpClient(guard=None) as client:
            with pytest.raises(LinkError, match=str(status)):
                await client.get(url)

    async def test_an_answer_that_is_too_long_is_not_read(self) -> None:
        async with serving(answering(body=b"x" * 1001)) as url, HttpClient(guard=None, max_bytes=1000) as client:
            with pytest.raises(WireError, match="more than 1000 bytes"):
                await client.get(url)
            assert len((await client.get(url, max_bytes=1001)).body) == 1001

    async def test_an_endless_answer_is_not_read(self) -> None:
        async def handle(request: web.Request) -> web.StreamResponse:
            response = web.StreamResponse()
            await response.prepare(request)
            try:
                while True:
                    await response.write(b"x" * 10_000)
            except ConnectionError:
                return response

        async with serving(handle) as url, HttpClient(guard=None) as client:
            with pytest.raises(WireError, match="more than"):
                await client.get(url)

    async def test_compressed_bytes_are_not_unpacked(self) -> None:
        async def handle(request: web.Request) -> web.Response:
            assert request.headers["Accept-Encoding"] == "identity"
            return web.Response(body=b"\x1f\x8b", headers={"Content-Encoding": "gzip"})

        async with serving(handle) as url, HttpClient(guard=None) as client:
            with pytest.raises(WireError, match="compressed"):
                await client.get(url)

    async def test_a_server_that_is_too_slow_is_a_lost_link(self) -> None:
        given_up = asyncio.Event()

        async def handle(request: web.Request) -> web.Response:
            await given_up.wait()
            return web.Response()

        async with serving(handle) as url, HttpClient(guard=None, time_limit=0.05) as client:
            with pytest.raises(LinkError, match=r"did not answer within 0\.05 s"):
                await client.get(url)
            given_up.set()

    async def test_a_missing_server_is_a_lost_link(self) -> None:
        async with serving(answering()) as url:
            pass
        async with HttpClient(guard=None) as client:
            with pytest.raises(
                LinkError, match=r"cannot be reached: nothing is listening there \(connection refused\)"
            ):
                await client.get(url)

    @pytest.mark.parametrize(
        ("sent", "error"),
        [
            (b"", LinkError),
            (b"HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\nabc", LinkError),
            (b"SSH-2.0-dropbear\r\n\r\n", WireError),
            (b"HTTP/1.1 200 OK\r\nContent-Length: x\r\n\r\n", WireError),
            (b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n", HomebotError),
            (b"HTTP/1.1 200 OK\r\nX: " + b"y" * 100_000 + b"\r\n\r\n", WireError),
            (b"HTTP/1.1 302 Found\r\nLocation: http://[\r\n\r\n", WireError),
            (b"HTTP/1.1 302 Found\r\nLocation: ftp://x/\r\n\r\n", WireError),
        ],
    )
    async def test_an_answer_that_is_not_http_is_an_error_of_ours(self, sent: bytes, error: type[HomebotError]) -> None:
        async def talk(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await reader.readuntil(b"\r\n\r\n")
            writer.write(sent)
            writer.close()

        server = await asyncio.start_server(talk, "127.0.0.1", 0)
        async with server, HttpClient(guard=None) as client:
            port = server.sockets[0].getsockname()[1]
            with pytest.raises(error):
                await client.get(f"http://127.0.0.1:{port}/")

    @pytest.mark.parametrize(
        "url", ["", "x", "ftp://h/", "http://", "http://[", "http://h:99999/", "mqtt://h/", "http://u:p4ss@h/"]
    )
    async def test_an_invalid_address_is_refused_and_not_shown(self, url: str) -> None:
        async with HttpClient(guard=None) as client:
            with pytest.raises(WireError) as caught:
                await client.get(url)
        assert "p4ss" not in str(caught.value)

    @pytest.mark.parametrize(("method", "content_type"), [("GE T", ""), ("PUT", "text/plain\r\nX: y"), ("get", "")])
    async def test_methods_and_types_are_checked(self, method: str, content_type: str) -> None:
        async with HttpClient(guard=None) as client:
            with pytest.raises(WireError):
                await client.request(method, "http://127.0.0.1:9/", content_type=content_type)

    async def test_redirects_are_followed_by_get_alone_and_not_for_ever(self) -> None:
        async def handle(request: web.Request) -> web.Response:
            if request.path == "/there":
                return web.Response(text="here")
            raise web.HTTPTemporaryRedirect("/there" if request.path == "/once" else "/again")

        async with serving(handle) as url, HttpClient(guard=None) as client:
            assert (await client.get(f"{url}/once")).body == b"here"
            with pytest.raises(RefusedError, match="redirects"):
                await client.get(f"{url}/again")
            with pytest.raises(RefusedError, match="307"):
                await client.request("PUT", f"{url}/once", body=b"")

    async def test_no_redirect_leads_to_another_host(self) -> None:
        """A device must not make homebot ask what listens for this computer alone."""
        asked: list[str] = []

        async def keep(request: web.Request) -> web.Response:
            asked.append(request.path)
            return web.Response(text="secret")

        async with serving(keep) as target, HttpClient(guard=None) as client:

            async def redirect(request: web.Request) -> web.Response:
                raise web.HTTPFound(f"{target.replace('127.0.0.1', 'localhost')}{request.path}")

            async with serving(redirect) as url:
                with pytest.raises(RefusedError, match="redirects to another host"):
                    await client.get(f"{url}/get")
                with pytest.raises(RefusedError, match="redirects to another host"):
                    async with client.events(f"{url}/events"):
                        pass
                with pytest.raises(RefusedError, match="redirects to another host"):
                    async with client.websocket(f"{url}/socket"):
                        pass
        assert asked == []


class TestLogins:
    def login(self, origin: str, scheme: str, user: str = "admin") -> HttpLogin:
        return HttpLogin(origin, scheme, user, SecretStr(PASSWORD))  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("scheme", "user", "field", "value"),
        [
            ("basic", "admin", "Authorization", "Basic YWRtaW46Y29ycmVjdCBob3JzZQ=="),
            ("bearer", "", "Authorization", f"Bearer {PASSWORD}"),
            ("header", "X-API-Key", "X-API-Key", PASSWORD),
        ],
    )
    async def test_credentials_are_sent_in_a_header_field(self, scheme: str, user: str, field: str, value: str) -> None:
        async def handle(request: web.Request) -> web.Response:
            return web.Response(text=request.headers.get(field, ""))

        async with serving(handle) as url, HttpClient(guard=None, login=self.login(url, scheme, user)) as client:
            assert (await client.get(url)).body.decode() == value

    @pytest.mark.parametrize("scheme", ["basic", "bearer", "header"])
    async def test_no_other_server_gets_the_password(self, scheme: str) -> None:
        seen = []

        async def other(request: web.Request) -> web.Response:
            seen.append(dict(request.headers))
            challenge = 'Digest qop="auth", realm="r", nonce="n", algorithm=MD5'
            return web.Response(status=401, headers={"WWW-Authenticate": challenge})

        async with serving(other) as elsewhere:

            async def first(request: web.Request) -> web.Response:
                raise web.HTTPFound(elsewhere)

            async with serving(first) as url, HttpClient(guard=None, login=self.login(url, scheme, "X-Key")) as client:
                with pytest.raises(RefusedError):
                    await client.get(url)
                with pytest.raises(RefusedError):
                    await client.get(elsewhere)
        assert len(seen) == 2
        assert not any({"Authorization", "X-Key"} & headers.keys() for headers in seen)

    async def test_no_error_shows_a_secret(self) -> None:
        async with serving(answering(401)) as url, HttpClient(guard=None, login=self.login(url, "basic")) as client:
            with pytest.raises(RefusedError, match="does not let homebot in") as caught:
                await client.get(f"{url}/x?token=s3cret")
            assert PASSWORD not in repr(client._login)
        assert "s3cret" not in str(caught.value)
        assert PASSWORD not in str(caught.value)

    async def test_without_a_password_the_error_says_that_one_is_wanted(self) -> None:
        async with serving(answering(401)) as url, HttpClient(guard=None) as client:
            with pytest.raises(RefusedError, match="wants a password"):
                await client.get(url)


class TestTls:
    async def test_a_server_is_trusted_by_the_authority_that_is_given(self) -> None:
        authority = trustme.CA()
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        authority.issue_cert("127.0.0.1").configure_cert(context)
        trusting = ssl.create_default_context()
        authority.configure_trust(trusting)
        runner = web.AppRunner(web.Application(), shutdown_timeout=0.1)
        await runner.setup()
        async with AsyncExitStack() as stack:
            stack.push_async_callback(runner.cleanup)
            await web.TCPSite(runner, "127.0.0.1", 0, ssl_context=context).start()
            url = http_origin("127.0.0.1", runner.addresses[0][1], "https")
            async with HttpClient(guard=None) as stranger:
                with pytest.raises(LinkError, match="is not trusted"):
                    await stranger.get(url)
            async with HttpClient(guard=None, tls=trusting) as client:
                with pytest.raises(RefusedError, match="404"):
                    await client.get(url)


class TestWebSockets:
    async def test_messages_go_both_ways(self) -> None:
        async def handle(request: web.Request) -> web.StreamResponse:
            socket = web.WebSocketResponse()
            await socket.prepare(request)
            async for message in socket:
                await (socket.send_str if message.type is WSMsgType.TEXT else socket.send_bytes)(message.data)
            return socket

        async with serving(handle) as url, HttpClient(guard=None) as client:  # noqa: SIM117 - too long for one
            async with client.websocket(f"{url}/rpc") as socket:
                await socket.send("hello")
                assert await socket.receive() == "hello"
                await socket.send(b"\x00")
                assert await socket.receive() == b"\x00"

    async def test_a_frame_that_is_too_long_ends_it(self) -> None:
        async def handle(request: web.Request) -> web.StreamResponse:
            socket = web.WebSocketResponse()
            await socket.prepare(request)
            await socket.send_str("x" * 2000)
            await socket.receive()
            return socket

        async with serving(handle) as url, HttpClient(guard=None) as client:  # noqa: SIM117 - too long for one
            async with client.websocket(url, max_bytes=1000) as socket:
                with pytest.raises(WireError, match="rules of WebSockets"):
                    await socket.receive()
                with pytest.raises(LinkError):
                    await socket.receive()

    async def test_a_server_that_closes_is_a_lost_link(self) -> None:
        async def handle(request: web.Request) -> web.StreamResponse:
            socket = web.WebSocketResponse()
            await socket.prepare(request)
            await socket.close()
            return socket

        async with serving(handle) as url, HttpClient(guard=None) as client, client.websocket(url) as socket:
            with pytest.raises(LinkError, match="closed the connection"):
                await socket.receive()
            with pytest.raises(LinkError):
                await socket.send("anyone?")

    async def test_a_server_that_falls_silent_is_a_lost_link(self) -> None:
        """It accepts, and never answers the ping that follows."""

        async def talk(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            request = await reader.readuntil(b"\r\n\r\n")
            (key,) = re.findall(rb"Sec-WebSocket-Key: (\S+)", request)
            accept = base64.b64encode(
                hashlib.sha1(key + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest()  # noqa: S324 - RFC 6455
            )
            writer.write(
                b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n"
            )
            await reader.read()
            writer.close()

        server = await asyncio.start_server(talk, "127.0.0.1", 0)
        async with server, HttpClient(guard=None) as client:
            url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/"
            async with client.websocket(url, heartbeat=0.1) as socket:
                with anyio.fail_after(PATIENCE), pytest.raises(LinkError):
                    await socket.receive()

    @pytest.mark.parametrize(("status", "error"), [(401, RefusedError), (404, RefusedError), (503, LinkError)])
    async def test_a_handshake_that_is_refused_has_the_status(self, status: int, error: type[HomebotError]) -> None:
        async with serving(answering(status)) as url, HttpClient(guard=None) as client:
            with pytest.raises(error, match=str(status)):
                async with client.websocket(url):
                    raise AssertionError

    @pytest.mark.parametrize("frame", [b"\x81\x01a", b"\x81\x00", b"\x89\x00"], ids=["texts", "empty texts", "pings"])
    @pytest.mark.no_cover
    async def test_a_flood_of_tiny_frames_lets_other_tasks_run(self, frame: bytes) -> None:
        async def receive(socket: WebSocket) -> None:
            while True:
                await socket.receive()

        async def flood(turns: Turns) -> None:
            with flooding(frame) as url:
                async with (
                    HttpClient(guard=None) as client,
                    client.websocket(url) as socket,
                    anyio.create_task_group() as tasks,
                ):
                    tasks.start_soon(receive, socket)
                    tasks.start_soon(turns.take_all)
                    await anyio.sleep(0.1)
                    tasks.cancel_scope.cancel()

        assert 0 < await longest_turn(flood, limit=0.005) < 0.005

    async def test_no_websocket_at_all_is_an_error_of_ours(self) -> None:
        async with serving(answering(200)) as url, HttpClient(guard=None) as client:
            with pytest.raises(WireError, match="opens no WebSocket"):
                async with client.websocket(url):
                    raise AssertionError


class TestEvents:
    async def test_events_come_as_they_are_sent_and_the_end_is_a_lost_link(self) -> None:
        async def handle(request: web.Request) -> web.StreamResponse:
            assert request.headers["Accept"] == "text/event-stream"
            response = web.StreamResponse(headers={"Content-Type": "text/event-stream; charset=utf-8"})
            await response.prepare(request)
            await response.write(b"retry: 2000\nid: 7\nevent: thing_updated\ndata: {}\n\nda")
            await response.write(b"ta: 2\n\n")
            return response

        async with serving(handle) as url, HttpClient(guard=None) as client:  # noqa: SIM117 - too long for one
            async with client.events(f"{url}/events") as events:
                stream = aiter(events)
                assert await anext(stream) == ServerEvent("thing_updated", "{}")
                assert await anext(stream) == ServerEvent("message", "2")
                with pytest.raises(LinkError, match="ended the stream"):
                    await anext(stream)

    async def test_an_event_that_is_too_long_ends_it(self) -> None:
        handler = answering(headers={"Content-Type": "text/event-stream"}, body=b"data: " + b"x" * 2000)
        async with (
            serving(handler) as url,
            HttpClient(guard=None, max_bytes=1000) as client,
            client.events(url) as events,
        ):
            with pytest.raises(WireError, match="longer than 1000"):
                await anext(aiter(events))

    async def test_an_answer_that_is_no_stream_of_events_is_refused(self) -> None:
        async with HttpClient(guard=None) as client:
            async with serving(answering(text="hello")) as url:
                with pytest.raises(WireError, match="text/plain"):
                    async with client.events(url):
                        raise AssertionError
            async with serving(answering(204)) as url:
                with pytest.raises(RefusedError, match="no events any more"):
                    async with client.events(url):
                        raise AssertionError
            async with serving(answering(404)) as url:
                with pytest.raises(RefusedError, match="404"):
                    async with client.events(url):
                        raise AssertionError


async def test_a_status_of_304_is_a_refusal() -> None:
    async def answer(_: web.Request) -> web.StreamResponse:
        return web.Response(status=304)

    async with serving(answer) as url, HttpClient(guard=None) as client:
        with pytest.raises(RefusedError, match="304"):
            await client.get(url)
