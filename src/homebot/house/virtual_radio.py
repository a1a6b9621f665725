"""Bluetooth in one process: virtual controllers on one link, and a bleak backend to it.

The one file that imports bumble, and so longer than others: radio and backend share its types. Devices advertise and
serve GATT as on a radio, but nothing is lost and distance does not count. The virtual controller reports a constant
-50 dBm, so that BlueZ, and filters, would see what no radio shows: each signal gets a strength of its own here,
around that of its device.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any
from uuid import UUID

import anyio
from bleak.backends.characteristic import BleakGATTCharacteristic
from bleak.backends.client import BaseBleakClient
from bleak.backends.device import BLEDevice
from bleak.backends.scanner import AdvertisementData, BaseBleakScanner
from bleak.backends.service import BleakGATTService, BleakGATTServiceCollection
from bleak.exc import (
    BleakBluetoothNotAvailableError,
    BleakBluetoothNotAvailableReason,
    BleakDeviceNotFoundError,
    BleakError,
)
from bleak.uuids import normalize_uuid_str
from bumble import core
from bumble.controller import Controller
from bumble.core import AdvertisingData, BaseBumbleError, PhysicalTransport
from bumble.device import AdvertisingType, Device, Peer
from bumble.gatt import Characteristic, CharacteristicValue, Service
from bumble.hci import (
    Address,
    HCI_ErrorCode,
    HCI_LE_Connection_Complete_Event,
    HCI_LE_Create_Connection_Cancel_Command,
    HCI_StatusReturnParameters,
    Role,
)
from bumble.host import Host
from bumble.link import LocalLink
from bumble.ll import AdvertisingPdu, AdvExtInd, AdvInd
from bumble.transport.common import AsyncPipeSink

from homebot.isolation import is_cancelled

if TYPE_CHECKING:
    from bumble.device import Advertisement as BumbleAdvertisement
    from bumble.device import Connection

__all__ = ["GattValue", "VirtualPeripheral", "VirtualRadio"]

HUB = "F0:F0:F0:F0:F0:FF"
RSSI = -60.0
JITTER = 3.0
"""Both in dB: how strongly a device is received, and how much that varies from packet to packet."""

CONNECT_WITHIN = 5.0
MTU = 247
_PROPERTIES = (
    (Characteristic.Properties.READ, "read"),
    (Characteristic.Properties.WRITE_WITHOUT_RESPONSE, "write-without-response"),
    (Characteristic.Properties.WRITE, "write"),
    (Characteristic.Properties.NOTIFY, "notify"),
    (Characteristic.Properties.INDICATE, "indicate"),
)
_SHORT_SERVICES = (
    AdvertisingData.Type.INCOMPLETE_LIST_OF_16_BIT_SERVICE_CLASS_UUIDS,
    AdvertisingData.Type.COMPLETE_LIST_OF_16_BIT_SERVICE_CLASS_UUIDS,
)
_LONG_SERVICES = (
    AdvertisingData.Type.INCOMPLETE_LIST_OF_128_BIT_SERVICE_CLASS_UUIDS,
    AdvertisingData.Type.COMPLETE_LIST_OF_128_BIT_SERVICE_CLASS_UUIDS,
)
_NAMES = (AdvertisingData.Type.SHORTENED_LOCAL_NAME, AdvertisingData.Type.COMPLETE_LOCAL_NAME)


@dataclass(frozen=True, slots=True)
class GattValue:
    """A characteristic that a device serves.

    Attributes:
        uuid: Its UUID, of 16 or 128 bits.
        read: Returns its value; None where it cannot be read.
        write: Takes a value; likewise.
        notifies: Whether clients may subscribe to it.
    """

    uuid: str
    read: Callable[[], bytes] | None = None
    write: Callable[[bytes], None] | None = None
    notifies: bool = False


class VirtualPeripheral:
    """A device on the radio, while it has power.

    Args:
        radio: The radio.
        device: Its stack.
        characteristics: What it serves, by UUID.

    Attributes:
        connected_times: How often it was connected to.
    """

    def __init__(self, radio: VirtualRadio, device: Device, characteristics: Mapping[str, Any]) -> None:
        self._radio = radio
        self._device = device
        self._characteristics = characteristics
        self.connected_times = 0
        device.on("connection", self._count)

    def _count(self, connection: Connection) -> None:
        del connection
        self.connected_times += 1

    async def advertise(self, fields: Sequence[tuple[int, bytes]], interval: float, *, connectable: bool) -> None:
        """Begin to advertise *fields*, types and bytes, every so many seconds, in place of what was advertised."""
        if connectable and self._device.connections:
            return  # it goes on by itself when it is disconnected
        kind = AdvertisingType.UNDIRECTED_CONNECTABLE_SCANNABLE if connectable else AdvertisingType.UNDIRECTED
        data = bytes(AdvertisingData([(AdvertisingData.Type(one), value) for one, value in fields]))
        milliseconds = interval * 1000
        with anyio.CancelScope(shield=True):  # a controller is not left in the middle of a command
            await self._device.stop_advertising()
            await self._device.start_advertising(
                advertising_type=kind,
                auto_restart=connectable,
                advertising_data=data,
                advertising_interval_min=milliseconds,
                advertising_interval_max=milliseconds,
            )

    async def advertise_nothing(self) -> None:
        """Be silent."""
        with anyio.CancelScope(shield=True):
            await self._device.stop_advertising()

    async def notify(self, uuid: str, value: bytes) -> None:
        """Notify all that subscribed to a characteristic."""
        await self._device.notify_subscribers(self._characteristics[uuid], value)

    async def lose_power(self) -> None:
        """Leave without a word: connections time out, and nothing is advertised."""
        await self._device.stop_advertising()
        for connection in list(self._device.connections.values()):
            await connection.disconnect(HCI_ErrorCode.CONNECTION_TIMEOUT_ERROR)
        await self._device.power_off()


class VirtualRadio:
    """A radio, and the adapter of a hub on it.

    Args:
        rng: The source of variation of the signals.

    Attributes:
        scanner: The class by which bleak scans with that adapter.
        client: The class by which it connects.
        scanners: The scans that run.
    """

    def __init__(self, rng: Random) -> None:
        self._rng = rng
        self._link = _Link()  # type: ignore[no-untyped-call]
        self._controller = _Controller("hub", link=self._link, public_address=HUB)
        self._hub = _device(self._controller, "hub", HUB)
        self._rssi: dict[str, float] = {}
        self._is_plugged = True
        self.scanners: set[_VirtualScanner] = set()
        self.scanner: type[object] = type("VirtualScanner", (_VirtualScanner,), {"radio": self})
        self.client: type[object] = type("VirtualClient", (_VirtualClient,), {"radio": self})

    @asynccontextmanager
    async def running(self) -> AsyncIterator[VirtualRadio]:
        """Run the adapter inside the block."""
        await self._hub.power_on()
        try:
            yield self
        finally:
            with anyio.CancelScope(shield=True):
                if self._hub.is_scanning:
                    await self._hub.stop_scanning()
                await self._hub.power_off()

    @asynccontextmanager
    async def peripheral(
        self, name: str, address: str, services: Mapping[str, Sequence[GattValue]] | None = None, rssi: float = RSSI
    ) -> AsyncIterator[VirtualPeripheral]:
        """Have a device on the radio inside the block.

        Args:
            name: What it is called.
            address: Its address, of a random static kind: the first byte is C0 to FF.
            services: The characteristics that it serves, by the UUID of the service.
            rssi: How strongly it is received, in dBm.
        """
        self._rssi[address] = rssi
        controller = Controller(name, link=self._link, public_address=address)
        device = _device(controller, name, address)
        served: dict[str, Any] = {}
        for uuid, values in (services or {}).items():
            own = {one.uuid: _characteristic(one) for one in values}
            device.add_service(Service(core.UUID(uuid), list(own.values())))
            served.update(own)
        await device.power_on()
        peripheral = VirtualPeripheral(self, device, served)
        try:
            yield peripheral
        finally:
            with anyio.CancelScope(shield=True):
                await peripheral.lose_power()
            self._link.remove_controller(controller)

    def transmit(self, address: str, fields: Sequence[tuple[int, bytes]]) -> None:
        """Have one advertisement heard from an address, which need not be that of a device; no controller is asked."""
        for scanner in tuple(self.scanners):
            scanner.hear(Address(address), fields)

    async def unplug(self) -> None:
        """Take the adapter away: connections end, and nothing is heard any more."""
        self._is_plugged = False
        for connection in list(self._hub.connections.values()):
            await connection.disconnect()

    def plug_in(self) -> None:
        """Give it back."""
        self._is_plugged = True

    def strength(self, address: str) -> int:
        """Return how strongly a packet from *address* is received now, in dBm."""
        return round(self._rng.gauss(self._rssi.get(address, RSSI), JITTER))

    def hub(self) -> Device:
        """Return the stack of the hub.

        Raises:
            BleakBluetoothNotAvailableError: The adapter was taken away.
        """
        if not self._is_plugged:
            raise BleakBluetoothNotAvailableError(
                "the adapter is not plugged in", BleakBluetoothNotAvailableReason.NO_BLUETOOTH
            )
        return self._hub

    def stop_connecting(self) -> None:
        """Give up the connection that the hub is opening, if any."""
        self._controller.pending_le_connection = None

    @property
    def is_plugged(self) -> bool:
        """True while the adapter is there."""
        return self._is_plugged


class _Controller(Controller):
    """A controller that stops connecting when it is asked to (Core 6.0, Vol 4, E 7.8.13).

    bumble's own says so and goes on: after one device that did not answer, it refuses every further connection.
    """

    def on_hci_le_create_connection_cancel_command(
        self, command: HCI_LE_Create_Connection_Cancel_Command
    ) -> HCI_StatusReturnParameters:
        pending, self.pending_le_connection = self.pending_le_connection, None
        if pending is not None:
            cancelled = HCI_LE_Connection_Complete_Event(
                status=HCI_ErrorCode.UNKNOWN_CONNECTION_IDENTIFIER_ERROR,
                connection_handle=0,
                role=Role.CENTRAL,
                peer_address_type=pending.peer_address.address_type,
                peer_address=pending.peer_address,
                connection_interval=0,
                peripheral_latency=0,
                supervision_timeout=0,
                central_clock_accuracy=0,
            )
            asyncio.get_running_loop().call_soon(self.send_hci_packet, cancelled)
        return super().on_hci_le_create_connection_cancel_command(command)


class _Link(LocalLink):
    """A link that names a sender by the address of its connection, as a radio does.

    Advertisements go to the controllers that listen: bumble hands each of them to all, which costs time that grows
    with the square of the devices.
    """

    def send_advertising_pdu(self, sender_controller: Controller, packet: AdvertisingPdu) -> None:
        loop = asyncio.get_running_loop()
        is_advertisement = isinstance(packet, AdvInd | AdvExtInd)
        for one in self.controllers:
            is_listening = one.le_scan_enable or one.pending_le_connection is not None
            if one is not sender_controller and (is_listening or not is_advertisement):
                loop.call_soon(one.on_ll_advertising_pdu, packet)

    def send_acl_data(
        self, sender_controller: Controller, destination_address: Address, transport: PhysicalTransport, data: bytes
    ) -> None:
        connection = sender_controller.le_connections.get(destination_address)
        if transport != PhysicalTransport.LE or connection is None:
            return
        destination = self.find_le_controller(destination_address)
        if destination is not None:
            destination.on_link_acl_data(connection.self_address, transport, data)


class _VirtualScanner(BaseBleakScanner):
    """bleak's scanner on a virtual adapter."""

    radio: VirtualRadio

    def __init__(
        self, detection_callback: Any, service_uuids: list[str] | None, mode: str = "active", **_: Any
    ) -> None:
        super().__init__(detection_callback, service_uuids)
        self._is_active = mode == "active"

    async def start(self) -> None:
        hub = self.radio.hub()
        self.seen_devices = {}
        hub.on("advertisement", self._hear)
        self.radio.scanners.add(self)
        await hub.start_scanning(active=self._is_active, filter_duplicates=False)

    async def stop(self) -> None:
        self.radio.scanners.discard(self)
        hub = self.radio.hub()
        hub.remove_listener("advertisement", self._hear)
        await hub.stop_scanning()

    def _hear(self, heard: BumbleAdvertisement) -> None:
        self.hear(heard.address, heard.data.ad_structures)

    def hear(self, sender: Address, fields: Sequence[tuple[int, bytes]]) -> None:
        """Report an advertisement to bleak."""
        if not self.radio.is_plugged:
            return
        address = sender.to_string(with_type_qualifier=False)
        data = _advertisement_data(fields, self.radio.strength(address))
        if not self.is_allowed_uuid(data.service_uuids):
            return
        device = self.create_or_update_device(address, address, data.local_name, {"address": sender}, data)
        self.call_detection_callbacks(device, data)


class _VirtualClient(BaseBleakClient):
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
        super().__init__(
            address_or_ble_device, disconnected_callback=disconnected_callback, timeout=min(timeout, CONNECT_WITHIN)
        )
        known = address_or_ble_device.details["address"] if isinstance(address_or_ble_device, BLEDevice) else None
        self._peer_address = known or Address(self.address)
        self._connection: Connection | None = None
        self._peer: Peer | None = None
        self._subscribed: dict[int, Callable[[bytes], None]] = {}

    @property
    def name(self) -> str:
        return self.address

    @property
    def mtu_size(self) -> int:
        return MTU

    @property
    def is_connected(self) -> bool:
        return self._connection is not None

    async def connect(self, pair: bool, **_: Any) -> None:  # noqa: FBT001 - bleak's signature
        del pair
        hub = self.radio.hub()
        try:
            connection = await hub.connect(self._peer_address, timeout=self._timeout)
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
        if self._disconnected_callback is not None:
            self._disconnected_callback()

    async def disconnect(self) -> None:
        if self._connection is not None:
            await self._connection.disconnect()

    async def pair(self, *_: Any, **__: Any) -> None:
        raise NotImplementedError("the virtual radio does not pair")  # as bleak's backends that cannot

    async def unpair(self) -> None:
        raise NotImplementedError("the virtual radio does not pair")  # as bleak's backends that cannot

    async def read_gatt_char(self, characteristic: BleakGATTCharacteristic, **_: Any) -> bytearray:
        self._check()
        return bytearray(await _answer(characteristic.obj.read_value()))

    async def read_gatt_descriptor(self, descriptor: Any, **_: Any) -> bytearray:
        self._check()
        return bytearray(await _answer(descriptor.obj.read_value()))

    async def write_gatt_char(
        self,
        characteristic: BleakGATTCharacteristic,
        data: Any,
        response: bool,  # noqa: FBT001 - bleak's signature
    ) -> None:
        self._check()
        await _answer(characteristic.obj.write_value(bytes(data), with_response=response))

    async def write_gatt_descriptor(self, descriptor: Any, data: Any) -> None:
        self._check()
        await _answer(descriptor.obj.write_value(bytes(data), with_response=True))

    async def start_notify(
        self, characteristic: BleakGATTCharacteristic, callback: Callable[[bytearray], None], **_: Any
    ) -> None:
        self._check()

        def hear(value: bytes) -> None:
            callback(bytearray(value))

        self._subscribed[characteristic.handle] = hear
        await _answer(characteristic.obj.subscribe(hear, prefer_notify="notify" in characteristic.properties))

    async def stop_notify(self, characteristic: BleakGATTCharacteristic) -> None:
        self._check()
        await _answer(characteristic.obj.unsubscribe(self._subscribed.pop(characteristic.handle)))

    def _check(self) -> None:
        if self._connection is None:
            raise BleakError("Not connected")


def _device(controller: Controller, name: str, address: str) -> Device:
    return Device(name=name, address=Address(address), host=Host(controller, AsyncPipeSink(controller)))


async def _answer(request: Any) -> Any:
    try:
        return await request
    except (BaseBumbleError, TimeoutError) as exc:
        raise BleakError(f"no answer: {exc!r}") from exc
    except asyncio.CancelledError as exc:
        if is_cancelled():
            raise
        raise BleakError("the connection was lost") from exc  # bumble cancels what waits for an answer


async def _discover(peer: Peer) -> BleakGATTServiceCollection:
    found = BleakGATTServiceCollection()
    for one in await peer.discover_services():
        service = BleakGATTService(one, one.handle, _uuid(one.uuid))
        found.add_service(service)
        for each in await one.discover_characteristics():
            names: list[Any] = [name for bit, name in _PROPERTIES if bit & each.properties]
            found.add_characteristic(
                BleakGATTCharacteristic(each, each.handle, _uuid(each.uuid), names, lambda: MTU - 3, service)
            )
    return found


def _uuid(uuid: core.UUID) -> str:
    text = uuid.to_hex_str("-").lower()
    return normalize_uuid_str(text) if len(text) <= 8 else text


def _uuid_of(raw: bytes) -> str:
    return str(UUID(bytes=raw[::-1])) if len(raw) == 16 else normalize_uuid_str(raw[::-1].hex())


def _characteristic(value: GattValue) -> Any:
    properties = Characteristic.Properties(0)
    permissions = Characteristic.Permissions(0)
    read, write = value.read, value.write
    if read is not None:
        properties |= Characteristic.Properties.READ
        permissions |= Characteristic.READABLE
    if write is not None:
        properties |= Characteristic.Properties.WRITE | Characteristic.Properties.WRITE_WITHOUT_RESPONSE
        permissions |= Characteristic.WRITEABLE
    if value.notifies:
        properties |= Characteristic.Properties.NOTIFY
    return Characteristic(
        core.UUID(value.uuid),
        properties,
        permissions,
        CharacteristicValue(
            read=None if read is None else (lambda _: read()),
            write=None if write is None else (lambda _, data: write(bytes(data))),
        ),
    )


def _advertisement_data(fields: Sequence[tuple[int, bytes]], rssi: int) -> AdvertisementData:
    name: str | None = None
    tx_power: int | None = None
    manufacturer: dict[int, bytes] = {}
    service_data: dict[str, bytes] = {}
    services: list[str] = []
    for kind, value in fields:
        if kind == AdvertisingData.Type.MANUFACTURER_SPECIFIC_DATA:
            manufacturer[int.from_bytes(value[:2], "little")] = value[2:]
        elif kind == AdvertisingData.Type.SERVICE_DATA_16_BIT_UUID:
            service_data[_uuid_of(value[:2])] = value[2:]
        elif kind == AdvertisingData.Type.SERVICE_DATA_128_BIT_UUID:
            service_data[_uuid_of(value[:16])] = value[16:]
        elif kind in _SHORT_SERVICES:
            services += [_uuid_of(value[at : at + 2]) for at in range(0, len(value), 2)]
        elif kind in _LONG_SERVICES:
            services += [_uuid_of(value[at : at + 16]) for at in range(0, len(value), 16)]
        elif kind in _NAMES:
            name = value.decode(errors="replace")
        elif kind == AdvertisingData.Type.TX_POWER_LEVEL:
            tx_power = int.from_bytes(value, "little", signed=True)
    # the virtual controller answers a scan with a copy of the advertisement
    return AdvertisementData(name, manufacturer, service_data, list(dict.fromkeys(services)), tx_power, rssi, ())
