"""Packets of multicast DNS, with services, damaged: what the gateway makes of them raises nothing."""

from tests.fuzz.conftest import Fuzz, Mutator
from tests.gateways.mdns.packets import AAAA, address, answer, pointer, record, service, text
from zeroconf._protocol.incoming import DNSIncoming
from zeroconf.asyncio import AsyncZeroconf

from homebot.conventions.dns_sd import facts_of, identifiers_of, read_txt
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.mdns.network import ServiceNews
from homebot.gateways.mdns.zeroconf_network import MAX_TTL, MdnsNetwork

LAMP = "_lamp._tcp.local."
NAMES = ("Hall", "Häll ✨", "", "a.b", "_sub", "x" * 63, "\x00", "A8032ABE54DC@Hall", "hall\x1b[2J")
HOSTS = ("hall.local.", "A8032ABE54DC.local.", "", "x" * 60 + ".local.", "hall._lamp._tcp.local.")
TEXTS = (b"\0", b"\x03a=1", b"\x0emac=a8032abe54dc", b"\xff", b"\x04=abc\x02id", bytes(range(256)), b"\x05id=\xff\xfe")


def packet(mutator: Mutator) -> bytes:
    rng = mutator.rng
    name, host = f"{rng.choice(NAMES)}.{LAMP}", rng.choice(HOSTS)
    ttl = rng.choice((0, 1, 120, 4500, 2**31, 2**32 - 1))
    data = rng.choice(TEXTS)
    records = [
        pointer(LAMP, name, ttl),
        service(name, host, rng.choice((0, 80, 65535)), ttl),
        text(name, mutator.damaged_bytes(data) if rng.random() < 0.5 else data, ttl),
        address(host, rng.choice(("127.0.0.1", "224.0.0.1", "0.0.0.0", "192.168.1.7")), ttl),  # noqa: S104
        record(host, AAAA, rng.randbytes(16), ttl),
    ]
    rng.shuffle(records)
    whole = answer(*records[: rng.choice((1, 3, 5, 5))])
    return mutator.damaged_bytes(whole) if rng.random() < 0.7 else whole


async def test_what_anybody_sends_on_the_network_raises_nothing(fuzz: Fuzz) -> None:
    heard: list[ServiceNews] = []
    async with MdnsNetwork.opened(("127.0.0.1",), heard.append, GatewayCounters()) as network:
        network.browse(LAMP)
        library = network._zeroconf
        assert isinstance(library, AsyncZeroconf)
        for mutator, rng in fuzz("mdns"):
            incoming = DNSIncoming(packet(mutator))
            if incoming.valid:
                library.zeroconf.record_manager.async_updates_from_response(incoming)
            for news in heard:
                check(network, news)
                if rng.random() < 0.5:
                    network.forget(news.service_type, news.name)
            heard.clear()


def check(network: MdnsNetwork, news: ServiceNews) -> None:
    found = network.resolve_cached(news.service_type, news.name)
    if found is None:
        return
    assert 0 <= found.left <= MAX_TTL
    assert 0 <= found.service.port <= 65535
    assert found.service.name.isprintable()
    assert all(value.isprintable() for value in facts_of(found.service).values())
    assert all(one.startswith(("mac:", "eui64:", "id:")) for one in identifiers_of(found.service))


def test_any_txt_record_is_read(fuzz: Fuzz) -> None:
    for mutator, rng in fuzz("txt"):
        read_txt(mutator.damaged_bytes(rng.choice(TEXTS)))
