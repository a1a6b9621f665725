"""Proxies that the owner lists by address: their contract, a plug-in group (``homebot.ble_proxies``), and keeper."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import anyio

from homebot.errors import LinkError, PeerError, PluginError, UsageError
from homebot.gateways.ble_proxies.settings import PROXIES, BleProxySettings
from homebot.plugins import check_extra, load_plugin
from homebot.support.backoff import Backoff, BackoffCounter
from homebot.support.ble_proxies import PROXY_EXTRA, BleProxies, ProxyGate
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from anyio.abc import TaskGroup

    from homebot.gateways.announced.published_devices import PublishedDevices

PROXY_FAILED = "ble.proxy_failed"

LASTED = 60.0
"""Seconds after which a connection that is lost counts as a first failure."""

_BACKOFF = Backoff(first=1.0, factor=2.0, cap=15.0, late_cap=60.0, late_after=300.0, jitter=0.5)


class BleProxy(ABC):
    """A Bluetooth receiver with a network address; a new one is made for each attempt to connect.

    Attributes:
        libraries: The top-level modules that it needs from the extra ``ble-proxies``.
        port: The usual TCP port of its kind.
    """

    libraries: ClassVar[tuple[str, ...]] = ()
    port: ClassVar[int]

    def __init__(self, settings: BleProxySettings, proxies: BleProxies, on_attached: Callable[[], object]) -> None:
        self.settings = settings
        self._proxies = proxies
        self._on_attached = on_attached

    @contextmanager
    def attached(
        self, source: str, name: str, room: str, make_scanner: Callable[[ProxyGate], object]
    ) -> Iterator[None]:
        """Hand its scanner over inside the block; see :meth:`BleProxies.attached`."""
        with self._proxies.attached(source, name, self.settings.room or room, make_scanner):
            self._on_attached()
            yield

    @abstractmethod
    async def run(self) -> None:
        """Connect, and hand over its advertisements, until cancelled; it is run again with growing pauses.

        Raises:
            LinkError: It cannot be reached, or the connection was lost.
            PeerError: It broke its protocol, or refuses homebot; the message gives the remedy.
            UsageError: Its key cannot be read.
        """


class ListedProxies:
    """The proxies of the configuration, each connected again whenever it is lost.

    Attributes:
        problems: Why proxies are not connected, by address.
    """

    def __init__(self, listed: Sequence[BleProxySettings], devices: PublishedDevices) -> None:
        self.problems: dict[str, str] = {}
        self._devices = devices
        self._listed = listed

    @staticmethod
    def check(listed: Sequence[BleProxySettings]) -> None:
        """Check libraries and keys before anything starts.

        Raises:
            UsageError: One is missing; the message gives the remedy.
        """
        check_extra("proxies", PROXY_EXTRA, "habluetooth")
        for proxy in listed:
            check_extra(f"a proxy of kind {proxy.kind}", PROXY_EXTRA, *_kind(proxy).libraries)
            proxy.read_key()

    def start(self, tasks: TaskGroup, proxies: BleProxies | None) -> None:
        """Run them in *tasks*; without *proxies*, as after a reload, they wait for a restart."""
        owner = self._devices.gateway.node.full_name
        for settings in self._listed:
            if proxies is None:
                self.problems[settings.place] = "it is connected to after a restart of homebot"
            else:
                tasks.start_soon(run_as, owner, partial(self._keep, settings, proxies))

    async def _keep(self, settings: BleProxySettings, proxies: BleProxies) -> None:
        gateway = self._devices.gateway
        retries = BackoffCounter(gateway.node.graph.clock, gateway.random, LASTED)
        while True:
            retries.begin()
            try:
                await _kind(settings)(settings, proxies, lambda: self.problems.pop(settings.place, None)).run()
            except (LinkError, PeerError, UsageError) as exc:
                self.problems[settings.place] = str(exc)
                self._devices.engine.quarantine.log_limited(PROXY_FAILED, f"{settings.place}: {exc}", source="")
            await anyio.sleep(retries.fail(_BACKOFF))


def _kind(settings: BleProxySettings) -> type[BleProxy]:
    kind = load_plugin(PROXIES, settings.kind)
    if not issubclass(kind, BleProxy):
        raise PluginError(settings.kind, "is not a BleProxy")
    return kind
