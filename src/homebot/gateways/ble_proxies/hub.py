"""The meeting point of a gateway's receivers: its own adapter and its proxies; the one file that imports habluetooth.

habluetooth decides which receiver's copies of a device's advertisements count, by smoothed signal strengths, and by
which proxy with a free slot a device is connected to. Of the others only the strength counts.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, cast

from bluetooth_adapters import BluetoothAdapters
from habluetooth import (
    BaseHaRemoteScanner,
    BluetoothManager,
    BluetoothServiceInfoBleak,
    HaBleakClientWrapper,
    set_manager,
)

from homebot.conventions.bluetooth.broadcast import Advertisement
from homebot.errors import RefusedError
from homebot.support.ble_proxies import BleProxies, ProxyGate

if TYPE_CHECKING:
    from bleak import BleakClient

    from homebot.clock import Clock
    from homebot.conventions.bluetooth.hearing import Hearing, RoomGuess


class OnAdvertisement(Protocol):
    """Takes an advertisement; it *counts* unless another receiver hears its device better."""

    def __call__(self, advertisement: Advertisement, *, counts: bool) -> None:
        """Take it."""


def _ignore(advertisement: Advertisement, *, counts: bool) -> None:
    """Take nothing."""
    del advertisement, counts


MAX_PROXIES = 30
LOCAL = ""
"""The receiver that is the adapter of this computer."""


class ProxyHub(BleProxies):
    """The receivers of one gateway, as a service of the host.

    Args:
        takes_found: Whether proxies are taken that the owner's gateways find.
    """

    def __init__(self, clock: Clock, *, takes_found: bool) -> None:
        self.takes_found = takes_found
        self._on_advertisement: OnAdvertisement = _ignore
        self._on_change: Callable[[], None] = lambda: None
        self._clock = clock
        self._manager = _Manager(self)
        self._proxies: dict[str, tuple[str, str, ProxyGate]] = {}
        self._refused_before = 0
        with self._chosen():
            self._local = BaseHaRemoteScanner(LOCAL, LOCAL)

    @contextmanager
    def running(self) -> Iterator[ProxyHub]:
        """Keep the tables of heard advertisements inside the block."""
        self._manager.begin()
        end = self._local.async_setup()
        leave = self._manager.async_register_scanner(self._local)
        try:
            yield self
        finally:
            leave()
            end()
            self._manager.async_stop()

    @contextmanager
    def listening(self, on_advertisement: OnAdvertisement, on_change: Callable[[], None]) -> Iterator[None]:
        """Hand on the advertisements that are heard inside the block.

        Args:
            on_advertisement: Called with each advertisement.
            on_change: Called when a proxy came or went.
        """
        self._on_advertisement, self._on_change = on_advertisement, on_change
        try:
            yield
        finally:
            self._on_advertisement, self._on_change = _ignore, lambda: None

    @property
    def has_proxy(self) -> bool:
        """True while a proxy is connected."""
        return bool(self._proxies)

    @property
    def refused(self) -> int:
        """The number of advertisements of all proxies that were dropped."""
        return self._refused_before + sum(gate.refused for _, _, gate in self._proxies.values())

    def place_of(self, hearing: Hearing, local_room: str, now: float) -> tuple[str, RoomGuess | None]:
        """Return the proxy that hears a device best, empty for none, and the room which all receivers suggest.

        Args:
            local_room: The room of the adapter of this computer.
        """
        rooms = {LOCAL: local_room, **{source: room for source, (_, room, _) in self._proxies.items()}}
        guess = hearing.room(now, {source: room for source, room in rooms.items() if room})
        strongest = hearing.strongest(now)
        is_proxy = strongest is not None and strongest[0] in self._proxies
        return self._proxies[strongest[0]][0] if strongest is not None and is_proxy else "", guess

    @contextmanager
    def attached(
        self, source: str, name: str, room: str, make_scanner: Callable[[ProxyGate], object]
    ) -> Iterator[None]:
        """Listen to a proxy inside the block."""
        if len(self._proxies) >= MAX_PROXIES:
            raise RefusedError(name, f"{MAX_PROXIES} Bluetooth proxies are connected already")
        if source in self._proxies or not source:
            raise RefusedError(name, f"another proxy has its address {source}")
        gate = ProxyGate(self._clock)
        with self._chosen():
            scanner = cast("BaseHaRemoteScanner", make_scanner(gate))
        end = scanner.async_setup()
        leave = self._manager.async_register_scanner(scanner)
        self._proxies[source] = name, room, gate
        self._on_change()
        try:
            yield
        finally:
            del self._proxies[source]
            self._refused_before += gate.refused
            end()
            leave()
            self._on_change()

    def hear_locally(self, heard: Advertisement) -> None:
        """Add an advertisement that the adapter of this computer received."""
        self._local._async_on_advertisement(  # noqa: SLF001 - the library's way to add one
            heard.address,
            heard.rssi,
            heard.name or None,
            list(heard.service_uuids),
            dict(heard.service_data),
            dict(heard.manufacturer_data),
            heard.tx_power,
            {},
            self._clock.monotonic(),
        )

    def reaches(self, address: str) -> bool:
        """Return whether a proxy that can connect hears a device."""
        return bool(self._manager.async_scanner_devices_by_address(address, connectable=True))

    def client(self, address: str, on_lost: Callable[[BleakClient], None], time_limit: float) -> BleakClient:
        """Return a client that connects by the best proxy with a free slot."""
        with self._chosen():
            return HaBleakClientWrapper(
                address, disconnected_callback=on_lost, timeout=time_limit, _is_retry_client=True
            )

    def receive(self, info: BluetoothServiceInfoBleak, *, counts: bool) -> None:
        """Hand on an advertisement of a receiver."""
        self._on_advertisement(
            Advertisement(
                address=info.address,
                rssi=info.rssi,
                name="" if info.name == info.address else info.name,
                tx_power=info.tx_power,
                service_data=info.service_data,
                manufacturer_data=info.manufacturer_data,
                service_uuids=tuple(info.service_uuids),
                receiver=info.source,
            ),
            counts=counts,
        )

    @contextmanager
    def _chosen(self) -> Iterator[None]:
        """Make this the place where scanners of the library that are made inside the block register."""
        set_manager(self._manager)
        yield


class _NoAdapters(BluetoothAdapters):
    """No adapters of the operating system: bleak alone uses that one."""

    @property
    def adapters(self) -> dict[str, Any]:
        return {}

    @property
    def default_adapter(self) -> str:
        return ""


class _Manager(BluetoothManager):
    """The library's arbiter, without its adapters, and without its replacement of bleak's classes."""

    def __init__(self, hub: ProxyHub) -> None:
        super().__init__(_NoAdapters())
        self._hub = hub
        self._copies: dict[str, Callable[[], None]] = {}  # ends of callbacks, as many as the library knows devices
        self.async_register_disappeared_callback(self._forget)

    def begin(self) -> None:
        """Begin to forget devices that are silent."""
        self._loop = asyncio.get_running_loop()
        self.async_setup_unavailable_tracking()

    def _discover_service_info(self, service_info: BluetoothServiceInfoBleak) -> None:
        """Take a changed advertisement, of the receiver that counts, and ask for every copy from then on."""
        self._hub.receive(service_info, counts=True)
        address = service_info.address
        if address not in self._copies:
            self._copies[address] = self.async_register_advertisement_callback(self._on_copy, address)

    def _on_copy(self, info: BluetoothServiceInfoBleak) -> None:
        last = self.async_last_service_info(info.address, connectable=False)
        self._hub.receive(info, counts=last is not None and last.source == info.source)

    def _forget(self, address: str) -> None:
        end = self._copies.pop(address, None)
        if end is not None:
            end()
