"""A Shelly device that the owner lists as a Bluetooth proxy, on a WebSocket of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import anyio

from homebot.conventions.payload import as_fields, text_of
from homebot.errors import LinkError, WireError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.ble_proxies.proxy import BleProxy
from homebot.gateways.http_address import http_origin
from homebot.integrations.shelly.bluetooth_proxy import LIBRARY, BluetoothRelay
from homebot.integrations.shelly.driver import RpcLink
from homebot.integrations.shelly.formats.gen2 import MAX_ANSWER_BYTES
from homebot.integrations.shelly.formats.gen2_rpc import RpcLogin
from homebot.support.isolation import ungrouped

if TYPE_CHECKING:
    from homebot.integrations.shelly.formats.status import Fields


class ShellyBleProxy(BleProxy):
    """A proxy that the owner lists by address; the script is written to it."""

    libraries: ClassVar[tuple[str, ...]] = ("aiohttp", LIBRARY)
    port: ClassVar[int] = 80

    async def run(self) -> None:
        """Connect, and hand over its advertisements, until the connection is lost."""
        from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - an extra

        settings = self.settings
        port, key = settings.port or self.port, settings.read_key()
        try:
            found = await anyio.getaddrinfo(settings.address, port)
        except OSError as exc:
            raise LinkError(f"the address {settings.address} is unknown: {exc.strerror}") from exc
        addresses = tuple(dict.fromkeys(place[4][0] for place in found))
        guard = AddressGuard(addresses)
        async with HttpClient(guard=guard, max_bytes=MAX_ANSWER_BYTES, time_limit=10.0) as client:
            origin = http_origin(addresses[0], port)
            about = as_fields(await client.get_json(f"{origin}/shelly"))
            relay = BluetoothRelay(about)
            device_id = text_of(about.get("id"))
            if not device_id or "mac" not in about:
                raise WireError(f"{settings.address} does not answer like a Shelly device of a later generation")

            async def on_notification(frame: Fields, _payload: bytes) -> None:
                relay.forward(frame)

            async with client.websocket(f"{origin}/rpc", max_bytes=MAX_ANSWER_BYTES) as socket:
                login = None if key is None else RpcLogin(key)
                rpc = RpcLink(socket, device_id, login, on_notification, lambda *_: None)
                with ungrouped():
                    async with anyio.create_task_group() as tasks:
                        tasks.start_soon(rpc.receive)
                        await relay.start(rpc.call, installs=True)
                        with relay.attached(self.attached):
                            await anyio.sleep_forever()
