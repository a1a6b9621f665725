"""A Bluetooth proxy of ESPHome: a server of the native API with its messages, and a lamp that it connects to.

Source: ESPHome 2026.10, ``components/bluetooth_proxy/bluetooth_proxy.cpp`` and ``api.proto``.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from typing import Any
from uuid import UUID

import anyio
from aioesphomeapi import api_pb2
from tests.integrations.esphome.simulated.device import EsphomeServedDevice, _ApiClient
from tests.integrations.esphome.simulated.wire import ApiMessage
from tests.patience import PATIENCE

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

PASSIVE, ACTIVE, CACHING, RAW, MODES = 1, 2, 4, 32, 64
_CONNECT = {0, 4, 5}
_CONNECTED = "BluetoothDeviceConnectionResponse"
_SLOTS = 3


def number_of(address: str) -> int:
    """Return an address as its messages have it."""
    return int(address.replace(":", ""), 16)


def _uuid(text: str) -> list[int]:
    whole = UUID(text).int
    return [whole >> 64, whole & (1 << 64) - 1]


class ProxyServer(EsphomeServedDevice):
    """A proxy; its own entity is a switch.

    Attributes:
        wants: How many clients listen to its radio.
        written: What was written to the characteristics of devices, by address and handle.
        connected: The devices that it is connected to.
    """

    def __init__(
        self, name: str, room: str, *, key: str = "", features: int = PASSIVE | ACTIVE | CACHING | RAW | MODES
    ) -> None:
        info = SimulatedDeviceInfo(home="home", kind="switch", device_id=name, service_type="plugs", room=room)
        super().__init__(info, lambda _: None, key=key)
        self.features = features
        self.written: list[tuple[int, int, bytes]] = []
        self.connected: set[int] = set()
        self.services: list[Any] = []
        self._clients: list[_ApiClient] = []
        self._listeners: list[_ApiClient] = []
        self._changed = anyio.Event()
        self.begin(DeviceState(text="off"), has_power=True)

    @property
    def wants(self) -> int:
        return len(self._listeners)

    async def until_wanted(self, count: int = 1) -> None:
        """Wait until so many clients listen to its radio."""
        with anyio.fail_after(PATIENCE):
            while self.wants < count:  # noqa: ASYNC110 - clients come at any time
                await anyio.sleep(0.01)

    def drop(self) -> None:
        """Disconnect the clients that listen, as a proxy that restarts."""
        self._tell(("DisconnectRequest", {}))

    def offer(self, service: str, characteristics: Mapping[str, int]) -> None:
        """Have devices offer a service with characteristics by UUID, with their properties; handles count from 2."""
        made = [
            api_pb2.BluetoothGATTCharacteristic(uuid=_uuid(uuid), handle=2 + at, properties=properties)  # type: ignore[attr-defined]
            for at, (uuid, properties) in enumerate(characteristics.items())
        ]
        self.services = [
            api_pb2.BluetoothGATTService(uuid=_uuid(service), handle=1, characteristics=made)  # type: ignore[attr-defined]
        ]

    def hear(self, *heard: tuple[str, int, bytes]) -> None:
        """Tell all clients of advertisements: address, signal strength and content."""
        advertisements = [
            api_pb2.BluetoothLERawAdvertisement(address=number_of(address), rssi=rssi, data=data)  # type: ignore[attr-defined]
            for address, rssi, data in heard
        ]
        self._tell(("BluetoothLERawAdvertisementsResponse", {"advertisements": advertisements}))

    def notify(self, address: str, handle: int, data: bytes) -> None:
        """Tell all clients of a value that a device notified."""
        fields = {"address": number_of(address), "handle": handle, "data": data}
        self._tell(("BluetoothGATTNotifyDataResponse", fields))

    def _tell(self, message: ApiMessage) -> None:
        for client in self._listeners:
            client.put(message)

    async def _talk(self, client: _ApiClient) -> None:
        self._clients.append(client)
        try:
            await super()._talk(client)
        finally:
            self._clients.remove(client)
            if client in self._listeners:
                self._listeners.remove(client)

    def _responses(self, name: str, fields: Mapping[str, Any]) -> tuple[ApiMessage, ...]:
        return tuple(self._answers(name, fields)) or super()._responses(name, fields)

    def _answers(self, name: str, fields: Mapping[str, Any]) -> Iterable[ApiMessage]:
        match name:
            case "DeviceInfoRequest":
                ((kind, info),) = super()._responses(name, fields)
                mac = f"{self.mac[:10]}FF".upper()
                pairs = ":".join(mac[at : at + 2] for at in range(0, 12, 2))
                yield kind, {**info, "bluetooth_proxy_feature_flags": self.features, "bluetooth_mac_address": pairs}
            case "SubscribeBluetoothLEAdvertisementsRequest":
                self._listeners = self._clients[-1:]  # the firmware has one
                yield "BluetoothScannerStateResponse", {"state": 2, "mode": 1, "configured_mode": 1}
            case "SubscribeBluetoothConnectionsFreeRequest":
                yield self._free()
            case "BluetoothDeviceRequest":
                address = fields["address"]
                is_wanted = fields["request_type"] in _CONNECT
                (self.connected.add if is_wanted else self.connected.discard)(address)
                yield _CONNECTED, {"address": address, "connected": is_wanted, "mtu": 247 if is_wanted else 0}
                yield self._free()
            case "BluetoothGATTGetServicesRequest":
                yield "BluetoothGATTGetServicesResponse", {"address": fields["address"], "services": self.services}
                yield "BluetoothGATTGetServicesDoneResponse", {"address": fields["address"]}
            case "BluetoothGATTWriteRequest":
                self.written.append((fields["address"], fields["handle"], fields["data"]))
                yield "BluetoothGATTWriteResponse", {"address": fields["address"], "handle": fields["handle"]}
            case "BluetoothGATTReadRequest":
                answer = {"address": fields["address"], "handle": fields["handle"], "data": b"\x00\x00"}
                yield "BluetoothGATTReadResponse", answer
            case "BluetoothGATTNotifyRequest":
                yield "BluetoothGATTNotifyResponse", {"address": fields["address"], "handle": fields["handle"]}

    def _free(self) -> ApiMessage:
        taken = sorted(self.connected)
        return "BluetoothConnectionsFreeResponse", {"free": _SLOTS - len(taken), "limit": _SLOTS, "allocated": taken}


@asynccontextmanager
async def serving(*proxies: ProxyServer) -> AsyncIterator[None]:
    """Let proxies serve inside the block."""
    async with anyio.create_task_group() as tasks:
        for proxy in proxies:
            tasks.start_soon(proxy.live)
            await proxy.listening.wait()
        yield
        tasks.cancel_scope.cancel()
