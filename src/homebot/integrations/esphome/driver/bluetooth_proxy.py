"""ESPHome's Bluetooth proxies (``bluetooth_proxy:``); the only file that imports bleak_esphome.

The driver of a device hands its proxy over on the connection that it has. A proxy that the owner lists by address has a
connection of its own, over which nothing else is read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, AsyncExitStack, contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import anyio
from anyio import to_thread

from homebot.errors import LinkError, RefusedError
from homebot.gateways.ble_proxies.proxy import BleProxy
from homebot.integrations.esphome.driver.settings import checked_key
from homebot.plugins import check_extra
from homebot.support.ble_proxies import PROXY_EXTRA, ProxyGate

if TYPE_CHECKING:
    from homebot.integrations.esphome.driver.connection import EsphomeConnection

Attach: TypeAlias = Callable[[str, str, str, Callable[[ProxyGate], object]], AbstractContextManager[object]]
"""See :meth:`homebot.support.ble_proxies.BleProxies.attached`."""

_LIBRARY = "bleak_esphome"


async def load_library() -> None:
    """Import the library, which takes a while, beside the event loop.

    Raises:
        UsageError: It is not installed.
    """
    check_extra("a Bluetooth proxy", PROXY_EXTRA, _LIBRARY)
    await to_thread.run_sync(import_module, _LIBRARY)


@contextmanager
def relaying(connection: EsphomeConnection, attach: Attach) -> Iterator[None]:
    """Hand over a device's advertisements, and connections by it, inside the block, after :func:`load_library`.

    Raises:
        RefusedError: It is no proxy, or not taken.
        LinkError: The connection was lost.
    """
    from bleak_esphome import connect_scanner  # noqa: PLC0415 - an extra

    info, client = connection.info, connection.client
    if not connection.is_bluetooth_proxy:
        raise RefusedError(
            connection.name, 'it is no Bluetooth proxy; add "bluetooth_proxy:" to its ESPHome configuration'
        )
    ends: list[Callable[[], None]] = []

    def make_scanner(gate: ProxyGate) -> object:
        client.gate = gate
        with connection.translated():
            data = connect_scanner(client, info, available=True)
        ends.extend((data.bluetooth_device.async_set_unavailable, lambda: _end(data.disconnect_callbacks)))
        return data.scanner

    source = info.bluetooth_mac_address or info.mac_address
    with attach(source, info.friendly_name or info.name, info.suggested_area, make_scanner):
        try:
            yield
        finally:
            for end in ends:
                end()


def _end(callbacks: set[Callable[[], None]]) -> None:
    """Tell the connections by a proxy that it is gone; each callback removes itself."""
    for callback in tuple(callbacks):
        callback()


class EsphomeBleProxy(BleProxy):
    """A proxy that the owner lists by address."""

    libraries: ClassVar[tuple[str, ...]] = ("aioesphomeapi", _LIBRARY)
    port: ClassVar[int] = 6053

    async def run(self) -> None:
        """Connect, and hand over its advertisements, until the connection is lost."""
        await load_library()
        from homebot.integrations.esphome.driver.connection import connected  # noqa: PLC0415 - an extra

        settings = self.settings
        key = checked_key(settings.read_key(), f'proxies."{settings.address}".')
        port = settings.port or self.port
        try:
            found = await anyio.getaddrinfo(settings.address, port)
        except OSError as exc:
            raise LinkError(f"the address {settings.address} is unknown: {exc.strerror}") from exc
        addresses = tuple(dict.fromkeys(place[4][0] for place in found))
        async with AsyncExitStack() as stack:
            try:
                connection = await stack.enter_async_context(connected(settings.address, addresses, port, key, None))
            except RefusedError as exc:
                advice = 'give the key that its ESPHome configuration has under "api: encryption:" as key_file, or none'
                raise RefusedError(f"the proxy {settings.address}", f"it wants another encryption; {advice}") from exc
            await connection.learn()
            with relaying(connection, self.attached):
                await connection.lost.wait()
        raise LinkError(f"the connection to {settings.address} was lost")
