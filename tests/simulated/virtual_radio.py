"""Bluetooth in one process: virtual controllers on one link; a hub uses it through bleak.

Only this file and :mod:`tests.simulated.virtual_bleak`, the backend of bleak, import bumble. Devices advertise and
serve GATT as on a radio, but nothing is lost, and distance does not matter. The virtual controller would report a
constant, implausible -50 dBm, so each packet gets a signal strength here, around that of its device.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any

import anyio
from bleak.exc import BleakBluetoothNotAvailableError, BleakBluetoothNotAvailableReason
from bumble import core
from bumble.controller import Controller
from bumble.core import AdvertisingData, PhysicalTransport
from bumble.device import AdvertisingType, Device
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

if TYPE_CHECKING:
    from bumble.device import Connection

HUB = "F0:F0:F0:F0:F0:FF"
RSSI = -60.0
JITTER = 3.0
"""The signal strength of a device, and its variation from packet to packet; both in dB."""


@dataclass(frozen=True, slots=True)
class GattValue:
    """A characteristic that a device serves.

    Attributes:
        uuid: Its UUID, of 16 or 128 bits.
        read: Returns its value; None if it is not readable.
    """

    uuid: str
    read: Callable[[], bytes] | None = None
    write: Callable[[bytes], None] | None = None
    notifies: bool = False


class VirtualPeripheral:
    """A device on the radio, while it has power."""

    def __init__(self, device: Device, characteristics: Mapping[str, Any]) -> None:
        self._device = device
        self._characteristics = characteristics
        self.connected_times = 0
        device.on("connection", self._count)

    def _count(self, connection: Connection) -> None:
        del connection
        self.connected_times += 1

    async def advertise(self, fields: Sequence[tuple[int, bytes]], interval: float, *, connectable: bool) -> None:
        """Advertise *fields*, types and bytes, at this interval in seconds, replacing earlier ones."""
        if connectable and self._device.connections:
            return  # it resumes by itself after a disconnection
        kind = AdvertisingType.UNDIRECTED_CONNECTABLE_SCANNABLE if connectable else AdvertisingType.UNDIRECTED
        data = bytes(AdvertisingData([(AdvertisingData.Type(kind), value) for kind, value in fields]))
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
        """Stop advertising."""
        with anyio.CancelScope(shield=True):
            await self._device.stop_advertising()

    async def notify(self, uuid: str, value: bytes) -> None:
        """Notify all subscribers to a characteristic."""
        await self._device.notify_subscribers(self._characteristics[uuid], value)

    async def lose_power(self) -> None:
        """Vanish silently: connections time out, and nothing is advertised."""
        await self._device.stop_advertising()
        for connection in list(self._device.connections.values()):
            await connection.disconnect(HCI_ErrorCode.CONNECTION_TIMEOUT_ERROR)
        await self._device.power_off()


class VirtualRadio:
    """A radio, and the adapter of a hub on it.

    Attributes:
        listeners: Called with the sender and the fields of each advertisement that :meth:`transmit` reports.
        is_plugged: Whether the adapter is plugged in.
    """

    def __init__(self, rng: Random) -> None:
        self._rng = rng
        self._link = _Link()  # type: ignore[no-untyped-call]
        self._controller = _Controller("hub", link=self._link, public_address=HUB)
        self._hub = _device(self._controller, "hub", HUB)
        self.is_plugged = True
        self.listeners: set[Callable[[Address, Sequence[tuple[int, bytes]]], None]] = set()

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
        self, name: str, address: str, services: Mapping[str, Sequence[GattValue]] | None = None
    ) -> AsyncIterator[VirtualPeripheral]:
        """Run a device on the radio inside the block.

        Args:
            address: Its address, of a random static kind: the first byte is C0 to FF.
            services: The characteristics that it serves, by the UUID of the service.
        """
        controller = Controller(name, link=self._link, public_address=address)
        device = _device(controller, name, address)
        served: dict[str, Any] = {}
        for uuid, values in (services or {}).items():
            own = {value.uuid: _characteristic(value) for value in values}
            device.add_service(Service(core.UUID(uuid), list(own.values())))
            served.update(own)
        await device.power_on()
        peripheral = VirtualPeripheral(device, served)
        try:
            yield peripheral
        finally:
            with anyio.CancelScope(shield=True):
                await peripheral.lose_power()
            self._link.remove_controller(controller)

    def transmit(self, address: str, fields: Sequence[tuple[int, bytes]]) -> None:
        """Report an advertisement from any address, without a controller."""
        for listener in tuple(self.listeners):
            listener(Address(address), fields)

    async def unplug(self) -> None:
        """Unplug the adapter: connections end, and no advertisements arrive."""
        self.is_plugged = False
        for connection in list(self._hub.connections.values()):
            await connection.disconnect()

    def plug_in(self) -> None:
        """Plug the adapter in again."""
        self.is_plugged = True

    def strength(self) -> int:
        """Return the signal strength of the next packet, in dBm."""
        return round(self._rng.gauss(RSSI, JITTER))

    def hub(self) -> Device:
        """Return the stack of the hub.

        Raises:
            BleakBluetoothNotAvailableError: The adapter is unplugged.
        """
        if not self.is_plugged:
            raise BleakBluetoothNotAvailableError(
                "the adapter is not plugged in", BleakBluetoothNotAvailableReason.NO_BLUETOOTH
            )
        return self._hub

    def stop_connecting(self) -> None:
        """Cancel the connection that the hub is opening, if any."""
        self._controller.pending_le_connection = None


class _Controller(Controller):
    """A controller that stops connecting when told to (Core 6.0, Vol 4, E 7.8.13).

    bumble's own only claims to: after one device that did not answer, it refuses every further connection.
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
    """A link that identifies a sender by the address of its connection, as a radio does.

    Advertisements only go to listening controllers: bumble passes each to all, which takes time proportional to the
    square of the number of devices.
    """

    def send_advertising_pdu(self, sender_controller: Controller, packet: AdvertisingPdu) -> None:
        loop = asyncio.get_running_loop()
        is_advertisement = isinstance(packet, AdvInd | AdvExtInd)
        for controller in self.controllers:
            is_listening = controller.le_scan_enable or controller.pending_le_connection is not None
            if controller is not sender_controller and (is_listening or not is_advertisement):
                loop.call_soon(controller.on_ll_advertising_pdu, packet)

    def send_acl_data(
        self, sender_controller: Controller, destination_address: Address, transport: PhysicalTransport, data: bytes
    ) -> None:
        connection = sender_controller.le_connections.get(destination_address)
        if transport != PhysicalTransport.LE or connection is None:
            return
        destination = self.find_le_controller(destination_address)
        if destination is not None:
            destination.on_link_acl_data(connection.self_address, transport, data)


def _device(controller: Controller, name: str, address: str) -> Device:
    return Device(name=name, address=Address(address), host=Host(controller, AsyncPipeSink(controller)))


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
