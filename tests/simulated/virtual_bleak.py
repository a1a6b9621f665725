"""The backend of bleak for a virtual Bluetooth adapter: scanner and client on the stack of bumble."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any
from uuid import UUID

from bleak.backends.characteristic import BleakGATTCharacteristic
from bleak.backends.client import BaseBleakClient
from bleak.backends.device import BLEDevice
from bleak.backends.scanner import AdvertisementData, BaseBleakScanner
from bleak.backends.service import BleakGATTService, BleakGATTServiceCollection
from bleak.exc import BleakDeviceNotFoundError, BleakError
from bleak.uuids import normalize_uuid_str
from bumble import core
from bumble.core import AdvertisingData, BaseBumbleError
from bumble.device import Peer
from bumble.gatt import Characteristic
from bumble.hci import Address
from tests.simulated.virtual_radio import VirtualRadio

from homebot.support.ble_backend import BleBackend
from homebot.support.isolation import is_cancelled

if TYPE_CHECKING:
    from bumble.device import Advertisement as BumbleAdvertisement
    from bumble.device import Connection

CONNECT_WITHIN = 5.0
MTU = 247
_PROPERTIES = (
    (Characteristic.Properties.READ, "read"),
    (Characteristic.Properties.WRITE_WITHOUT_RESPONSE, "write-without-response"),
    (Characteristic.Properties.WRITE, "write"),
    (Characteristic.Properties.NOTIFY, "notify"),
    (Characteristic.Properties.INDICATE, "indicate"),
)
_SERVICES: Mapping[int, int] = {
    AdvertisingData.Type.INCOMPLETE_LIST_OF_16_BIT_SERVICE_CLASS_UUIDS: 2,
    AdvertisingData.Type.COMPLETE_LIST_OF_16_BIT_SERVICE_CLASS_UUIDS: 2,
    AdvertisingData.Type.INCOMPLETE_LIST_OF_128_BIT_SERVICE_CLASS_UUIDS: 16,
    AdvertisingData.Type.COMPLETE_LIST_OF_128_BIT_SERVICE_CLASS_UUIDS: 16,
}
"""Fields that list services: the bytes of each."""

_SERVICE_DATA: Mapping[int, int] = {
    AdvertisingData.Type.SERVICE_DATA_16_BIT_UUID: 2,
    AdvertisingData.Type.SERVICE_DATA_128_BIT_UUID: 16,
}
"""Fields with the data of a service: the bytes of the service."""

_NAMES = (AdvertisingData.Type.SHORTENED_LOCAL_NAME, AdvertisingData.Type.COMPLETE_LOCAL_NAME)


def backend_of(radio: VirtualRadio) -> BleBackend:
    """Return the classes by which bleak scans with the adapter of *radio*, and connects."""
    return BleBackend(
        scanner=type("VirtualScanner", (VirtualScanner,), {"radio": radio}),
        client=type("VirtualClient", (VirtualClient,), {"radio": radio}),
    )


class VirtualScanner(BaseBleakScanner):
    """bleak's scanner on a virtual adapter."""

    radio: VirtualRadio

    def __init__(
        self, detection_callback: Any, service_uuids: list[str] | None, mode: str = "active", **_: Any
    ) -> None:
        super().__init__(detection_callback, service_uuids)
        self._is_active = mode == "active"

    async def start(self) -> None:
        """Begin to scan."""
        hub = self.radio.hub()
        self.seen_devices = {}
        hub.on("advertisement", self._on_advertisement)
        self.radio.listeners.add(self.report)
        await hub.start_scanning(active=self._is_active, filter_duplicates=False)

    async def stop(self) -> None:
        """End the scan."""
        self.radio.listeners.discard(self.report)
        hub = self.radio.hub()
        hub.remove_listener("advertisement", self._on_advertisement)
        await hub.stop_scanning()

    def _on_advertisement(self, advertisement: BumbleAdvertisement) -> None:
        self.report(advertisement.address, advertisement.data.ad_structures)

    def report(self, sender: Address, fields: Sequence[tuple[int, bytes]]) -> None:
        """Report an advertisement to bleak."""
        if not self.radio.is_plugged:
            return
        address = sender.to_string(with_type_qualifier=False)
        data = _advertisement_data(fields, self.radio.strength())
        if not self.is_allowed_uuid(data.service_uuids):
            return
        device = self.create_or_update_device(address, address, data.local_name, {"address": sender}, data)
        self.call_detection_callbacks(device, data)


class VirtualClient(BaseBleakClient):
    """bleak's client on a virtual adapter."""

    radio: VirtualRadio

    def __init__(
        self,
        address_or_ble_device: BLEDevice | str,
        *,
        disconnected_callback: Callable[[], None] | None,
        timeout: float,
        **_: Any,
    ) -> None:
        super().__init__(address_or_ble_device, disconnected_callback=disconnected_callback, timeout=timeout)
        self._on_lost, self._connects_within = disconnected_callback, min(timeout, CONNECT_WITHIN)
        known = address_or_ble_device.details["address"] if isinstance(address_or_ble_device, BLEDevice) else None
        self._peer_address = known or Address(self.address)
        self._connection: Connection | None = None
        self._peer: Peer | None = None
        self._subscribed: dict[int, Callable[[bytes], None]] = {}

    @property
    def name(self) -> str:
        """The name of the peer, as far as it is known."""
        return self.address

    @property
    def mtu_size(self) -> int:
        """Bytes that one packet may carry."""
        return MTU

    @property
    def is_connected(self) -> bool:
        """True while there is a connection."""
        return self._connection is not None

    async def connect(self, pair: bool, **_: Any) -> None:  # noqa: FBT001 - bleak's signature
        """Connect and discover the services."""
        del pair
        hub = self.radio.hub()
        try:
            connection = await hub.connect(self._peer_address, timeout=self._connects_within)
        except (BaseBumbleError, TimeoutError) as exc:
            raise BleakDeviceNotFoundError(self.address, f"no connection was made: {exc!r}") from exc
        except asyncio.CancelledError:
            self.radio.stop_connecting()
            raise
        self._connection = connection
        connection.on("disconnection", self._lose)
        self._peer = Peer(connection)
        await _answer(self._peer.request_mtu(MTU))
        self.services = await _answer(_discover(self._peer))

    def _lose(self, reason: int) -> None:
        del reason
        self._connection = None
        if self._on_lost is not None:
            self._on_lost()

    async def disconnect(self) -> None:
        """End the connection."""
        if self._connection is not None:
            await self._connection.disconnect()

    async def pair(self, *_: Any, **__: Any) -> None:
        """Refuse, as bleak's backends do that cannot pair."""
        raise NotImplementedError("the virtual radio does not pair")

    async def unpair(self) -> None:
        """Refuse, as :meth:`pair`."""
        raise NotImplementedError("the virtual radio does not pair")

    async def read_gatt_char(self, characteristic: BleakGATTCharacteristic, **_: Any) -> bytearray:
        """Return the value of a characteristic."""
        self._check()
        return bytearray(await _answer(characteristic.obj.read_value()))

    async def read_gatt_descriptor(self, descriptor: Any, **_: Any) -> bytearray:
        """Return the value of a descriptor."""
        self._check()
        return bytearray(await _answer(descriptor.obj.read_value()))

    async def write_gatt_char(
        self,
        characteristic: BleakGATTCharacteristic,
        data: Any,
        response: bool,  # noqa: FBT001 - bleak's signature
    ) -> None:
        """Write a characteristic."""
        self._check()
        await _answer(characteristic.obj.write_value(bytes(data), with_response=response))

    async def write_gatt_descriptor(self, descriptor: Any, data: Any) -> None:
        """Write a descriptor."""
        self._check()
        await _answer(descriptor.obj.write_value(bytes(data), with_response=True))

    async def start_notify(
        self, characteristic: BleakGATTCharacteristic, callback: Callable[[bytearray], None], **_: Any
    ) -> None:
        """Subscribe to a characteristic."""
        self._check()

        def on_value(value: bytes) -> None:
            callback(bytearray(value))

        self._subscribed[characteristic.handle] = on_value
        await _answer(characteristic.obj.subscribe(on_value, prefer_notify="notify" in characteristic.properties))

    async def stop_notify(self, characteristic: BleakGATTCharacteristic) -> None:
        """Unsubscribe from a characteristic."""
        self._check()
        await _answer(characteristic.obj.unsubscribe(self._subscribed.pop(characteristic.handle)))

    def _check(self) -> None:
        if self._connection is None:
            raise BleakError("Not connected")


async def _answer(request: Any) -> Any:
    try:
        return await request
    except (BaseBumbleError, TimeoutError) as exc:
        raise BleakError(f"no answer: {exc!r}") from exc
    except asyncio.CancelledError as exc:
        if is_cancelled():
            raise
        raise BleakError("the connection was lost") from exc  # bumble cancels pending requests


async def _discover(peer: Peer) -> BleakGATTServiceCollection:
    services = BleakGATTServiceCollection()
    for peer_service in await peer.discover_services():
        service = BleakGATTService(peer_service, peer_service.handle, _uuid(peer_service.uuid))
        services.add_service(service)
        for characteristic in await peer_service.discover_characteristics():
            names: list[Any] = [name for bit, name in _PROPERTIES if bit & characteristic.properties]
            services.add_characteristic(
                BleakGATTCharacteristic(
                    characteristic, characteristic.handle, _uuid(characteristic.uuid), names, lambda: MTU - 3, service
                )
            )
    return services


def _uuid(uuid: core.UUID) -> str:
    text = uuid.to_hex_str("-").lower()
    return normalize_uuid_str(text) if len(text) <= 8 else text


def _uuid_of(raw: bytes) -> str:
    return str(UUID(bytes=raw[::-1])) if len(raw) == 16 else normalize_uuid_str(raw[::-1].hex())


def _advertisement_data(fields: Sequence[tuple[int, bytes]], rssi: int) -> AdvertisementData:
    name: str | None = None
    tx_power: int | None = None
    manufacturer: dict[int, bytes] = {}
    service_data: dict[str, bytes] = {}
    services: list[str] = []
    for kind, value in fields:
        if kind == AdvertisingData.Type.MANUFACTURER_SPECIFIC_DATA:
            manufacturer[int.from_bytes(value[:2], "little")] = value[2:]
        elif size := _SERVICE_DATA.get(kind):
            service_data[_uuid_of(value[:size])] = value[size:]
        elif size := _SERVICES.get(kind):
            services += [_uuid_of(value[at : at + size]) for at in range(0, len(value), size)]
        elif kind in _NAMES:
            name = value.decode(errors="replace")
        elif kind == AdvertisingData.Type.TX_POWER_LEVEL:
            tx_power = int.from_bytes(value, "little", signed=True)
    # the virtual controller answers a scan with a copy of the advertisement
    return AdvertisementData(name, manufacturer, service_data, list(dict.fromkeys(services)), tx_power, rssi, ())
