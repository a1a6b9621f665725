"""The adapter to bleak, the one file that imports it: scanning, and connections to devices.

bleak's errors become :class:`LinkError` here. Without D-Bus, or without BlueZ, bleak lets bare errors of the operating
system through, which count as an adapter that is missing.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import TYPE_CHECKING, Literal, cast

import anyio
from bleak import BleakClient, BleakScanner
from bleak.assigned_numbers import AdvertisementDataType
from bleak.exc import BleakBluetoothNotAvailableError, BleakError, BleakGATTProtocolError

from homebot.conventions.bluetooth.broadcast import Advertisement
from homebot.errors import LinkError, RefusedError
from homebot.gateways.ble.intake import BluetoothUnavailableError
from homebot.support.ble_backend import BleBackend
from homebot.support.unanswered import awaiting_answer

if TYPE_CHECKING:
    from bleak.args.bluez import BlueZScannerArgs, OrPatternLike
    from bleak.backends.client import BaseBleakClient
    from bleak.backends.device import BLEDevice
    from bleak.backends.scanner import AdvertisementData, BaseBleakScanner

    from homebot.gateways.ble_proxies.hub import ProxyHub

CONNECT_WITHIN = 20.0
ANSWER_WITHIN = 10.0
"""Both in seconds."""

_ERRORS = (BleakError, OSError, EOFError)
_PATTERNS: list[OrPatternLike] = [
    (0, AdvertisementDataType.FLAGS, b"\x02"),
    (0, AdvertisementDataType.FLAGS, b"\x06"),
    (0, AdvertisementDataType.FLAGS, b"\x1a"),
    (0, AdvertisementDataType.SERVICE_DATA_UUID16, b"\xd2\xfc"),
    (0, AdvertisementDataType.SERVICE_DATA_UUID16, b"\xaa\xfe"),
    (0, AdvertisementDataType.MANUFACTURER_SPECIFIC_DATA, b"\x4c\x00\x02\x15"),
]
"""The patterns that BlueZ needs to listen passively. These are the flags that nearly every device sends
(Core Specification Supplement, Part A, 1.3), BTHome, Eddystone and iBeacon."""


class BleRadio:
    """Bluetooth through bleak.

    Args:
        backend: The stack to use; None for that of the operating system.
        adapter: The name of the adapter, on Linux; empty for the system's.
        proxies: The receivers in other rooms; None for none.
    """

    def __init__(
        self, backend: BleBackend | None, adapter: str, *, is_passive: bool, proxies: ProxyHub | None = None
    ) -> None:
        self._proxies = proxies
        self._scanner_backend = None if backend is None else cast("type[BaseBleakScanner]", backend.scanner)
        self._client_backend = None if backend is None else cast("type[BaseBleakClient]", backend.client)
        self._adapter = adapter
        self._is_passive = is_passive
        self._scanner: BleakScanner | None = None

    @property
    def heard(self) -> int:
        """The number of addresses that the running scan has seen."""
        return 0 if self._scanner is None else len(self._scanner.discovered_devices_and_advertisement_data)

    @asynccontextmanager
    async def scanning(self, on_heard: Callable[[Advertisement], None]) -> AsyncIterator[None]:
        """Run a scan inside the block.

        Raises:
            BluetoothUnavailableError: There is no adapter, or it was removed.
        """

        def on_advertisement(device: BLEDevice, data: AdvertisementData) -> None:
            on_heard(_advertisement(device, data))

        with _unavailable_errors():
            bluez: BlueZScannerArgs = {"or_patterns": _PATTERNS} if self._is_passive else {}
            if self._adapter:
                bluez["adapter"] = self._adapter
            mode: Literal["active", "passive"] = "passive" if self._is_passive else "active"
            scanner = BleakScanner(on_advertisement, None, mode, bluez=bluez, backend=self._scanner_backend)
            with anyio.fail_after(ANSWER_WITHIN):
                await scanner.start()
        self._scanner = scanner
        try:
            yield
        finally:
            # If it cannot be stopped, the adapter is gone; the next start reports that.
            with anyio.CancelScope(shield=True), anyio.move_on_after(ANSWER_WITHIN), suppress(*_ERRORS):
                await scanner.stop()

    async def connect(self, address: str, on_lost: Callable[[], None]) -> BleLink:
        """Connect to a device, by a proxy where this computer does not hear it, and discover its services.

        Raises:
            BluetoothUnavailableError: There is no adapter.
            LinkError: The device cannot be reached.
        """
        known = {} if self._scanner is None else self._scanner.discovered_devices_and_advertisement_data
        device = next((candidate for candidate, _ in known.values() if candidate.address.upper() == address), None)
        with _unavailable_errors(only_adapter=True), _link_errors(address):
            if device is None and self._proxies is not None and self._proxies.reaches(address):
                client = self._proxies.client(address, lambda _: on_lost(), CONNECT_WITHIN)
            else:
                client = BleakClient(
                    device or address,
                    disconnected_callback=lambda _: on_lost(),
                    timeout=CONNECT_WITHIN,
                    bluez={"adapter": self._adapter} if self._adapter else {},
                    backend=self._client_backend,
                )
            with anyio.fail_after(CONNECT_WITHIN + ANSWER_WITHIN):
                await client.connect()
        return BleLink(client, address)


class BleLink:
    """A connection to one device; characteristics are named by their full UUIDs.

    Its methods raise LinkError if the connection is lost, and RefusedError if the device refuses.
    """

    def __init__(self, client: BleakClient, address: str) -> None:
        self._client = client
        self._address = address

    @property
    def is_open(self) -> bool:
        """True while the connection is open."""
        return self._client.is_connected

    def has(self, characteristic: str, *properties: str) -> bool:
        """Return whether the device has a characteristic, with at least one of *properties* if any are given."""
        known = self._client.services.get_characteristic(characteristic)
        return known is not None and (not properties or bool({*properties} & {*known.properties}))

    async def read(self, characteristic: str) -> bytes:
        """Return the value of a characteristic."""
        with _link_errors(self._address), anyio.fail_after(ANSWER_WITHIN):
            return bytes(await self._client.read_gatt_char(characteristic))

    async def write(self, characteristic: str, data: bytes, *, response: bool) -> None:
        """Set the value of a characteristic; with *response*, wait until the device has acknowledged it."""
        with awaiting_answer(), _link_errors(self._address), anyio.fail_after(ANSWER_WITHIN):
            await self._client.write_gatt_char(characteristic, data, response=response)

    async def subscribe(self, characteristic: str, on_value: Callable[[bytes], None]) -> None:
        """Call *on_value* with each value that the device notifies."""
        with _link_errors(self._address), anyio.fail_after(ANSWER_WITHIN):
            await self._client.start_notify(characteristic, lambda _, data: on_value(bytes(data)))

    async def close(self) -> None:
        """Disconnect; does nothing if the connection was lost already."""
        with anyio.CancelScope(shield=True), anyio.move_on_after(ANSWER_WITHIN), suppress(*_ERRORS):
            await self._client.disconnect()


def _advertisement(device: BLEDevice, data: AdvertisementData) -> Advertisement:
    return Advertisement(
        address=device.address.upper(),
        rssi=data.rssi,
        name=data.local_name or "",
        tx_power=data.tx_power,
        service_data={uuid.lower(): bytes(content) for uuid, content in data.service_data.items()},
        manufacturer_data={company: bytes(content) for company, content in data.manufacturer_data.items()},
        service_uuids=tuple(uuid.lower() for uuid in data.service_uuids),
    )


@contextmanager
def _unavailable_errors(*, only_adapter: bool = False) -> Iterator[None]:
    """Turn errors of bleak, or those that name the adapter, into :class:`BluetoothUnavailableError`."""
    try:
        yield
    except BleakBluetoothNotAvailableError as exc:
        raise BluetoothUnavailableError(f"Bluetooth is not available: {exc.args[0]}") from exc
    except _ERRORS as exc:
        if only_adapter:
            raise
        raise BluetoothUnavailableError(f"Bluetooth is not available: {_words(exc)}") from exc


@contextmanager
def _link_errors(address: str) -> Iterator[None]:
    try:
        yield
    except BleakBluetoothNotAvailableError:
        raise
    except BleakGATTProtocolError as exc:
        raise RefusedError(address, f"the device answered {_words(exc)}") from exc
    except _ERRORS as exc:
        raise LinkError(f"{address} cannot be reached: {_words(exc)}") from exc


def _words(error: BaseException) -> str:
    if isinstance(error, TimeoutError):
        return "it did not answer in time"
    if isinstance(error, FileNotFoundError):
        return "there is no D-Bus; on Linux, bluetoothd and the system bus must be running"
    if "org.bluez was not provided" in str(error):
        return "bluetoothd is not running"
    return str(error)[:200] or type(error).__name__
