"""The network as seen by multicast DNS. The only file that imports zeroconf.

Two surprises of the library: it raises the time to live of a PTR record to at least 1,125 s, so that its expiry says
little; and the TTLs of an ``AsyncServiceInfo`` are constants, not those that the peer sent. The true time to live of a
service is that of its SRV record, which is read from the cache.

Sources: RFC 6762 (Multicast DNS), RFC 6763 (DNS-Based Service Discovery).
"""

from __future__ import annotations

import ipaddress
from collections.abc import AsyncIterator, Callable, Collection, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Literal

import anyio
from zeroconf import Error, IPVersion, RecordUpdate, ServiceInfo, ServiceStateChange, Zeroconf, current_time_millis
from zeroconf._handlers.record_manager import RecordManager
from zeroconf._protocol.incoming import DNSIncoming
from zeroconf.asyncio import AsyncServiceBrowser, AsyncServiceInfo, AsyncZeroconf

from homebot.conventions.dns_sd import (
    ENUMERATION,
    FoundService,
    base_type,
    full_type,
    instance_label,
    is_service_type,
    printable,
    read_txt,
    usable_addresses,
)
from homebot.errors import LinkError
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.mdns.network import Interfaces, OwnService, ResolvedService, ServiceNetwork, ServiceNews
from homebot.support.addresses import is_loopback

MAX_TYPES = 100
"""Service types that are browsed at once; a house has up to fifty."""

MAX_ADDRESSES = 64
"""Addresses of a host that are kept, the newest: a computer has a few on each interface, and all are read each time."""

MAX_PLANNED = 10_000
"""Records after which a browser plans no more queries: as many as the library keeps of all hosts."""

MAX_TTL = 4500.0
"""Seconds: the longest time to live that RFC 6762, section 10, recommends for any record."""

UNKNOWN_TTL = 120.0
"""Seconds: the recommendation of section 10 for SRV records; used when the record is not cached any more."""

_CLOSING = 4.0
"""Seconds for the goodbyes, which take half of one: a cancelled closing leaves its sockets open."""

_SRV = 33  # RFC 2782
_ADDRESS_TYPES = frozenset({1, 28})  # A (RFC 1035) and AAAA (RFC 3596)


class _Browser(AsyncServiceBrowser):
    """A browser that survives a flood of names.

    The library plans a query for each name, and keeps the plan until shortly before the record would expire, also if
    its cache dropped that long ago. After a flood, :meth:`MdnsNetwork.ask_again` alone queries.
    """

    _heard = 0

    def async_update_records(self, zc: Zeroconf, now: float, records: list[RecordUpdate]) -> None:
        """Take news of records."""
        super().async_update_records(zc, now, records)
        self._heard += len(records)
        if self._heard > MAX_PLANNED:
            self.query_scheduler.stop()


class _Records(RecordManager):
    """The reader of responses, which tells browsers of a response before it returns, but not who sent it.

    Attributes:
        sender: The address that sent the response being read; empty while none is.
    """

    sender = ""

    def async_updates_from_response(self, msg: DNSIncoming) -> None:
        """Read a response."""
        self.sender = msg.source[0] if msg.source else ""
        super().async_updates_from_response(msg)
        self.sender = ""


class MdnsNetwork(ServiceNetwork):
    """The network behind some interfaces, used as ``async with MdnsNetwork.opened(…) as network``."""

    def __init__(
        self,
        zeroconf: AsyncZeroconf,
        interfaces: Interfaces,
        on_news: Callable[[ServiceNews], None],
        counters: GatewayCounters,
    ) -> None:
        self._zeroconf = zeroconf
        self._records = zeroconf.zeroconf.record_manager = _Records(zeroconf.zeroconf)
        self._interfaces = interfaces
        self._on_news = on_news
        self._counters = counters
        self._browsers: dict[str, _Browser] = {}
        self._own: dict[str, tuple[OwnService, ServiceInfo]] = {}

    @classmethod
    @asynccontextmanager
    async def opened(
        cls, interfaces: Interfaces, on_news: Callable[[ServiceNews], None], counters: GatewayCounters
    ) -> AsyncIterator[MdnsNetwork]:
        """Open the network inside the block; leaving it withdraws the announced services.

        Args:
            on_news: Called with news of services; it must not raise.
            counters: Counts refused service types and addresses.

        Raises:
            LinkError: It cannot be opened.
        """
        with _used_on(interfaces):
            zeroconf = AsyncZeroconf(zc=Zeroconf(interfaces=list(interfaces), ip_version=_version(interfaces)))
        network = cls(zeroconf, interfaces, on_news, counters)
        try:
            with _used_on(interfaces):
                await zeroconf.zeroconf.async_wait_for_start()
            yield network
        finally:
            with anyio.CancelScope(shield=True), anyio.move_on_after(_CLOSING):
                for browser in network._browsers.values():
                    await browser.async_cancel()
                network._browsers.clear()
                await network._zeroconf.async_close()

    async def change_interfaces(self, interfaces: Interfaces) -> None:
        """Use other interfaces from now on, also for announced services."""
        self._interfaces = interfaces
        with _used_on(interfaces):
            await self._zeroconf.async_update_interfaces(list(interfaces), _version(interfaces))
            for service, info in tuple(self._own.values()):
                await self._update(service, info.name)

    def browse(self, service_type: str) -> None:
        """Look for services of a type from now on; for :data:`ENUMERATION`, for all types there are."""
        if service_type in self._browsers:
            return
        if len(self._browsers) >= MAX_TYPES:
            self._counters.types_refused += 1
            return
        take = self._on_type_change if service_type == ENUMERATION else self._on_change
        self._browsers[service_type] = _Browser(self._zeroconf.zeroconf, service_type, handlers=[take])

    async def ask_again(self, service_types: Collection[str] | None = None) -> None:
        """Look for types again, by default for all, for services that were missed; known ones are reported again."""
        for service_type in self._browsers.keys() & (self._browsers.keys() if service_types is None else service_types):
            await self._browsers[service_type].async_cancel()
            del self._browsers[service_type]
            self.browse(service_type)

    def resolve_cached(self, service_type: str, name: str) -> ResolvedService | None:
        """Return a service from cached records; None if some are missing or expired."""
        try:
            info = AsyncServiceInfo(service_type, name)
        except Error:
            return None
        cache = info.load_from_cache(self._zeroconf.zeroconf)
        return self._resolve(info, service_type, name) if cache else None

    async def resolve(self, service_type: str, name: str, within: float) -> ResolvedService | None:
        """Ask for the records of a service that have expired or were never received.

        Returns:
            The service; None if it does not answer. One that answers without a TXT record, which RFC 6763 demands,
            is one all the same.
        """
        try:
            info = AsyncServiceInfo(service_type, name)
            is_complete = await info.async_request(self._zeroconf.zeroconf, within * 1000)
        except Error:  # a name that is none, or the network was closed meanwhile
            return None
        is_enough = is_complete or (info.server and info.port is not None and info.parsed_addresses())
        return self._resolve(info, service_type, name) if is_enough else None

    def forget(self, service_type: str, name: str) -> None:
        """Drop the cached records of a service, so that its next announcement is news."""
        cache = self._zeroconf.zeroconf.cache
        pointers = [
            record
            for record in cache.async_entries_with_name(base_type(service_type))
            if getattr(record, "alias", "").lower() == name.lower()
        ]
        cache.async_remove_records({*pointers, *cache.async_entries_with_name(name)})

    async def announce(self, service: OwnService) -> str:
        """Announce a service of homebot in place of one of the same type; return the name that it got.

        If another computer has a service of that name, a number is added to it (RFC 6762, section 9). A service that
        keeps its name is not withdrawn first: its peers keep it.
        """
        if service.service_type in self._own:
            known, info = self._own[service.service_type]
            if known.host == service.host and _label(info) == service.name:
                await self._update(service, info.name)
                return service.name
        await self.withdraw(service.service_type)
        info = self._info(service, f"{service.name}.{base_type(full_type(service.service_type))}")
        try:
            sent = await self._zeroconf.async_register_service(info, allow_name_change=True)
            # Not before: until then the name may belong to another host.
            self._own[service.service_type] = service, info
            await sent
        except Error as exc:
            self._own.pop(service.service_type, None)
            raise LinkError(f"{service.name} cannot be announced as {service.service_type}: {exc}") from exc
        return _label(info)

    async def withdraw(self, service_type: str) -> None:
        """Withdraw a service of homebot with a goodbye; does nothing if there is none of that type."""
        if service_type in self._own:
            _, info = self._own.pop(service_type)
            await (await self._zeroconf.async_unregister_service(info))

    async def _update(self, service: OwnService, name: str) -> None:
        """Announce other records of a service under the name that it has; does nothing if they are the same."""
        info = self._info(service, name)
        _, before = self._own[service.service_type]
        self._own[service.service_type] = service, info
        if (info.port, info.text, info.addresses) != (before.port, before.text, before.addresses):
            await (await self._zeroconf.async_update_service(info))

    def _info(self, service: OwnService, name: str) -> ServiceInfo:
        addresses = [address for address in service.addresses if not ipaddress.ip_address(address).is_unspecified]
        return ServiceInfo(
            full_type(service.service_type),
            name,
            port=service.port,
            properties=dict(service.properties),
            server=f"{service.host}.local.",
            parsed_addresses=addresses or _addresses(self._interfaces),
        )

    def _on_change(self, *, service_type: str, name: str, state_change: ServiceStateChange, **_: object) -> None:
        if any(info.name.lower() == name.lower() for _, info in self._own.values()):
            return
        kind: Literal["seen", "gone"] = "gone" if state_change is ServiceStateChange.Removed else "seen"
        self._on_news(ServiceNews(kind, service_type, name, self._records.sender))

    def _on_type_change(self, *, name: str, state_change: ServiceStateChange, **_: object) -> None:
        service_type = full_type(name)
        if (
            state_change is not ServiceStateChange.Removed
            and is_service_type(service_type)
            and service_type != ENUMERATION
        ):
            self.browse(service_type)

    def _resolve(self, info: AsyncServiceInfo, service_type: str, name: str) -> ResolvedService:
        ttl, left = self._time_to_live(name)
        # the library keeps 10,000 records, of any hosts
        cache = self._zeroconf.zeroconf.cache
        kept = [record for record in cache.async_entries_with_name(info.server or "") if record.type in _ADDRESS_TYPES]
        if len(kept) > MAX_ADDRESSES:
            old = sorted(kept, key=lambda record: record.created)[:-MAX_ADDRESSES]
            cache.async_remove_records(old)
            self._counters.addresses_refused += len(old)
        newest = info.parsed_scoped_addresses()[:MAX_ADDRESSES]
        with_loopback = any(is_loopback(address) for address in _addresses(self._interfaces))
        addresses = usable_addresses(newest, with_loopback=with_loopback)
        record = read_txt(info.text)
        service = FoundService(
            key=name,
            name=printable(instance_label(name, service_type)),
            service_type=base_type(service_type),
            host=(info.server or "").lower(),
            port=info.port or 0,
            addresses=addresses,
            properties=record.properties,
        )
        problem = record.problem or ("" if addresses else "it has no address that can be connected to")
        return ResolvedService(service, ttl, left, problem, info.text)

    def _time_to_live(self, name: str) -> tuple[float, float]:
        """Return the time to live of the SRV record of a service, and the seconds that are left of it."""
        now = current_time_millis()
        kept = self._zeroconf.zeroconf.cache.async_entries_with_name(name)
        records = [record for record in kept if record.type == _SRV and not record.is_expired(now)]
        if not records:
            return UNKNOWN_TTL, UNKNOWN_TTL
        newest = max(records, key=lambda record: record.get_remaining_ttl(now))
        return min(float(newest.ttl), MAX_TTL), min(float(newest.get_remaining_ttl(now)), MAX_TTL)


@contextmanager
def _used_on(interfaces: Interfaces) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError, Error) as exc:
        raise LinkError(f"mDNS cannot be used on {', '.join(map(str, interfaces))}: {exc}") from exc


def _label(info: ServiceInfo) -> str:
    return instance_label(info.name, info.type)


def _version(interfaces: Interfaces) -> IPVersion:
    return IPVersion.All if any(isinstance(interface, int) for interface in interfaces) else IPVersion.V4Only


def _addresses(interfaces: Interfaces) -> list[str]:
    return [interface for interface in interfaces if isinstance(interface, str)]
