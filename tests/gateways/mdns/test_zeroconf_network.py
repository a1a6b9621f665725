"""What is kept of hosts that announce more and more is bounded, and news say which host told them."""

import ipaddress
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import anyio
from tests.gateways.mdns.lamp import HOST, LOOPBACK, SERVICE_TYPE
from tests.gateways.mdns.packets import AAAA, address, answer, pointer, record, service, text
from tests.patience import PATIENCE
from zeroconf._protocol.incoming import DNSIncoming
from zeroconf.asyncio import AsyncZeroconf

from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.mdns.network import ServiceNews
from homebot.gateways.mdns.zeroconf_network import MAX_ADDRESSES, MAX_PLANNED, MdnsNetwork

LAMP = "_lamp._tcp.local."
NAME = f"Hall.{LAMP}"
FIRST = int(ipaddress.IPv6Address("2001:db8::1"))


@asynccontextmanager
async def hearing(counters: GatewayCounters) -> AsyncIterator[tuple[MdnsNetwork, AsyncZeroconf, Callable[..., None]]]:
    """A network, the library below it, and what has it hear records."""
    async with MdnsNetwork.opened(("127.0.0.1",), lambda _: None, counters) as network:
        library = network._zeroconf
        assert isinstance(library, AsyncZeroconf)

        def hear(*records: bytes) -> None:
            library.zeroconf.record_manager.async_updates_from_response(DNSIncoming(answer(*records)))

        yield network, library, hear


async def test_a_host_keeps_its_newest_addresses() -> None:
    counters = GatewayCounters()
    async with hearing(counters) as (network, library, hear):
        hear(pointer(LAMP, NAME), service(NAME, HOST, 80), text(NAME, b"\0"), address(HOST, "192.168.1.7"))
        for number in range(MAX_ADDRESSES + 10):
            hear(record(HOST, AAAA, ipaddress.IPv6Address(FIRST + number).packed, unique=False))
        found = network.resolve_cached(LAMP, NAME)
        assert found is not None
        assert len(found.service.addresses) == MAX_ADDRESSES
        assert str(ipaddress.IPv6Address(FIRST + MAX_ADDRESSES + 9)) in found.service.addresses
        assert len(library.zeroconf.cache.async_entries_with_name(HOST)) == MAX_ADDRESSES
        assert counters.addresses_refused == 11


async def test_names_without_end_leave_no_queries_behind() -> None:
    async with hearing(GatewayCounters()) as (network, _, hear):
        network.browse(LAMP)
        for first in range(0, 3 * MAX_PLANNED, 100):
            hear(*(pointer(LAMP, f"fake {number}.{LAMP}") for number in range(first, first + 100)))
        assert len(network._browsers[LAMP].query_scheduler._query_heap) <= MAX_PLANNED


async def test_news_say_which_host_told_them() -> None:
    heard: dict[str, str] = {}
    complete = anyio.Event()

    def hear(news: ServiceNews) -> None:
        heard[news.name] = news.sender
        if len(heard) == 2:
            complete.set()

    async with MdnsNetwork.opened((LOOPBACK,), hear, GatewayCounters()) as network:
        network.browse(SERVICE_TYPE)
        for sender in ("127.0.0.7", "127.0.0.8"):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
                opened.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(LOOPBACK))
                opened.bind((sender, 0))
                opened.sendto(answer(pointer(SERVICE_TYPE, f"{sender}.{SERVICE_TYPE}")), ("224.0.0.251", 5353))
        with anyio.fail_after(PATIENCE):
            await complete.wait()
    assert heard == {f"127.0.0.{number}.{SERVICE_TYPE}": f"127.0.0.{number}" for number in (7, 8)}
