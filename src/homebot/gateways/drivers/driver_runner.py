"""The runner of the driver of one service, which passes commands to it."""

from collections.abc import Callable, MutableMapping
from dataclasses import replace
from typing import Final

import anyio

from homebot.conventions.dns_sd import FoundService
from homebot.devices.gateway_messages import Command
from homebot.gateways.announced.device_runner import DeviceRunner
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.drivers import Driver
from homebot.gateways.drivers.installed_drivers import UsableDriver
from homebot.support.backoff import Backoff

__all__ = ["LOST_BACKOFF", "DriverRunner"]

LOST_BACKOFF: Final = Backoff(first=1.0, factor=2.0, cap=15.0, late_cap=60.0, late_after=300.0, jitter=0.5)
"""After a lost connection: a device that restarts is back within seconds."""

CONNECTED_WITHIN: Final = 5.0
"""Seconds for which a command waits for a connection."""


class DriverRunner(DeviceRunner):
    """Runs the driver of one service, and publishes its descriptions and reports.

    Args:
        publish: Publishes the device and the reason: by the driver's description, or None for only the facts of DNS-SD.
        behind: The published devices behind the device, by key.
    """

    def __init__(
        self,
        driver: UsableDriver,
        service: FoundService,
        devices: PublishedDevices,
        publish: Callable[[GatewayDevice | None, str], None],
        behind: MutableMapping[str, GatewayDevice] | None = None,
    ) -> None:
        super().__init__(service.name, service.key, devices, LOST_BACKOFF, behind)
        self._service = service
        self._kind = driver
        self._publish = publish
        self._driver: Driver | None = None
        self._connected = anyio.Event()
        self._is_connecting = True

    def change(self, service: FoundService) -> None:
        """Update the records of the service; restart the driver if host, port or TXT record changed."""
        before, self._service = self._service, service
        if _place(before) != _place(service):
            self.restart()

    @property
    def is_connected(self) -> bool:
        """True while its driver is connected to the device."""
        return self._driver is not None and self._connected.is_set()

    async def work(self) -> None:
        """Run the driver once."""
        self._is_connecting, self._connected = True, anyio.Event()
        self._driver = self._kind.kind(self._service, self._kind.settings, self)
        await self._driver.run()

    async def perform(self, command: Command) -> None:
        """Carry out *command*; wait a moment for a connection in progress."""
        if self._is_connecting:
            with anyio.move_on_after(CONNECTED_WITHIN):
                await self._connected.wait()
        if self._driver is None or not self.is_connected:
            raise self.not_connected()
        await self._driver.perform(command)

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device, now connected, under the key of its service."""
        self.sleeps = device.sleeps
        self.on_answer()
        self._publish(replace(device, key=self.key), "its driver has described it")
        self._connected.set()
        self._is_connecting = False
        self.report_reachable(reachable=True)

    def list_unheard(self) -> None:
        """Publish the device as known from DNS-SD."""
        self._publish(None, "its driver has not described it")

    def on_end(self) -> None:
        """Publish the loss of the connection."""
        self._driver = None
        self._is_connecting = False
        self._connected.set()  # no caller may wait for it any longer
        self._connected = anyio.Event()
        super().on_end()


def _place(service: FoundService) -> tuple[object, ...]:
    return service.host, service.port, dict(service.properties)
