"""No spelling of this computer's addresses is connected to by a client that strangers lead."""

import socket
from collections.abc import AsyncIterator, Iterator
from contextlib import aclosing, asynccontextmanager

import anyio
import pytest
from aiohttp import web
from tests.gateways.http_servers import serving
from tests.patience import PATIENCE

from homebot.errors import LinkError, PeerError, RefusedError
from homebot.gateways.address_guard import AddressGuard, OwnAddressError, guard_for
from homebot.gateways.coap.aiocoap_client import CoapClient
from homebot.gateways.http_client import HttpClient

SPELLINGS = [
    "127.0.0.1",
    "127.1",
    "2130706433",
    "0x7f.1",
    "0.0.0.0",  # noqa: S104 - it is connected to
    "127.9.9.9",
    "localhost",
    socket.gethostname(),
    "[::1]",
    "[::]",
    "[::ffff:127.0.0.1]",
    "[::ffff:0:0]",
]


@asynccontextmanager
async def canary() -> AsyncIterator[tuple[int, list[str]]]:
    """Listen at all addresses of this computer; yield the port and what was connected."""
    connected: list[str] = []

    async def on_connection(stream: anyio.abc.SocketStream) -> None:
        connected.append("connected")
        await stream.aclose()

    listener = await anyio.create_tcp_listener(local_port=0)
    port = listener.extra(anyio.abc.SocketAttribute.local_port)  # noqa: S610 - not Django
    async with listener, anyio.create_task_group() as tasks:
        tasks.start_soon(listener.serve, on_connection)
        yield port, connected
        tasks.cancel_scope.cancel()


@pytest.fixture
def udp_canary() -> Iterator[socket.socket]:
    """Receives datagrams at all addresses of this computer."""
    with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as bound:
        bound.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
        bound.bind(("::", 0))
        bound.setblocking(False)
        yield bound


@pytest.mark.parametrize("host", SPELLINGS)
async def test_no_http_client_of_strangers_connects_to_this_computer(host: str) -> None:
    """Numbers that are no IPv4 address in full are refused by newer versions of aiohttp."""
    problem = "leads to this computer|is no address of HTTP"
    async with canary() as (port, connected), HttpClient(guard=AddressGuard()) as client:
        with pytest.raises(PeerError, match=problem):
            await client.get(f"http://{host}:{port}/")
        with pytest.raises(PeerError, match=problem):
            async with client.websocket(f"ws://{host}:{port}/"):
                pass
        with pytest.raises(PeerError, match=problem):
            async with client.events(f"http://{host}:{port}/"):
                pass
        assert connected == []


@pytest.mark.parametrize(
    "group", ["224.0.1.187", "[ff02::fd%lo]", "[ff05::fd]", "[::ffff:224.0.1.187]", "239.255.255.250"]
)
async def test_no_coap_client_of_strangers_sends_to_all_hosts_of_a_group(group: str) -> None:
    async with CoapClient.open(PATIENCE, ()) as client:
        with pytest.raises(RefusedError, match="leads to this computer"):
            await client.guarded_by(AddressGuard()).request("PUT", f"coap://{group}/light", b"1")


@pytest.mark.parametrize("host", SPELLINGS)
@pytest.mark.parametrize("scheme", ["coap", "coap+tcp"])
async def test_no_coap_client_of_strangers_sends_to_this_computer(
    host: str, scheme: str, udp_canary: socket.socket
) -> None:
    async with canary() as (tcp, connected), CoapClient.open(5.0, ()) as opened:
        client = opened.guarded_by(AddressGuard())
        uri = f"{scheme}://{host}:{udp_canary.getsockname()[1] if scheme == 'coap' else tcp}/on"
        with pytest.raises(RefusedError, match="leads to this computer"):
            await client.request("PUT", uri, b"true")
        with pytest.raises(RefusedError, match="leads to this computer"):
            async with aclosing(client.observe(uri)) as states:
                await anext(states)
        with pytest.raises(BlockingIOError):
            udp_canary.recv(100)
        assert connected == []


@pytest.mark.parametrize("zone", [1, 2, 99])
def test_a_zone_hides_no_address_of_this_computer(zone: int) -> None:
    """The kernel looks at the zone of link-local addresses alone."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as routed:
        if routed.connect_ex(("203.0.113.7", 9)):
            pytest.skip("this computer has no address")
        own = routed.getsockname()[0]
    with pytest.raises(OwnAddressError):
        AddressGuard().check((f"::ffff:{own}", 80, 0, zone))


async def test_a_redirect_is_judged_by_the_address_that_it_leads_to() -> None:
    """The host is the same name; the address that it is resolved to has changed meanwhile."""

    async def answer(_: web.Request) -> web.StreamResponse:
        raise web.HTTPFound(f"http://127.0.0.1:{port}/")

    class Rebound(AddressGuard):
        judged = 0

        def check(self, found: tuple[str, int] | tuple[str, int, int, int]) -> str:
            self.judged += 1
            return super().check(found) if self.judged > 1 else "10.0.0.7"

    async with canary() as (port, connected), serving(answer) as url, HttpClient(guard=Rebound()) as client:
        with pytest.raises(RefusedError, match="leads to this computer"):
            await client.get(url)
        assert connected == []


async def test_an_address_that_the_gateway_vouches_for_is_connected_to() -> None:
    async def answer(_: web.Request) -> web.StreamResponse:
        return web.json_response(data=True)

    async with serving(answer) as url, HttpClient(guard=AddressGuard(["127.0.0.1"])) as client:
        assert await client.get_json(url) is True


async def test_only_a_directory_on_this_computer_may_list_what_runs_here() -> None:
    for host in ("127.0.0.1", "127.1", "::1", socket.gethostname()):
        assert (await guard_for(host)).of_described is None
    for host in ("203.0.113.7", "no-such-host.invalid", "x" * 70, ""):
        assert (await guard_for(host)).of_described is not None


async def test_a_directory_whose_name_leads_to_another_host_as_well_is_on_that(monkeypatch: pytest.MonkeyPatch) -> None:
    def look_up(*_: object, **__: object) -> list[object]:
        return [(socket.AF_INET, socket.SOCK_DGRAM, 17, "", (one, 0)) for one in ("127.0.0.1", "203.0.113.7")]

    monkeypatch.setattr(socket, "getaddrinfo", look_up)
    assert (await guard_for("directory.test")).of_described is not None


async def test_a_directory_on_this_computer_is_read_nowhere_else_when_its_name_leads_elsewhere() -> None:
    guard = await guard_for("localhost")
    async with HttpClient(guard=guard) as client:
        with pytest.raises(LinkError, match="leads to another host"):
            await client.get("http://203.0.113.7/things")
    async with CoapClient.open(PATIENCE, ()) as opened:
        with pytest.raises(LinkError, match="leads to another host"):
            await opened.guarded_by(guard).request("GET", "coap://203.0.113.7/.well-known/core")


async def test_a_name_that_is_unknown_is_a_lost_link() -> None:
    async with CoapClient.open(PATIENCE, ()) as opened:
        client = opened.guarded_by(AddressGuard())
        for host in ("no-such-host.invalid", "x" * 70):
            with pytest.raises(LinkError):
                await client.request("GET", f"coap://{host}/")
