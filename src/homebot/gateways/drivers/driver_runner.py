"""The drivers of an mDNS gateway: those that can be used, and the runner of the driver of one service."""

from collections.abc import Callable, Collection, Mapping, MutableMapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import anyio
from pydantic import ValidationError

from homebot.config import in_folder
from homebot.conventions.dns_sd import FoundService, full_type
from homebot.devices.gateway_messages import Command
from homebot.errors import PluginError, UsageError
from homebot.gateways.announced.device_runner import DeviceRunner
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.drivers import Driver, DriverSettings
from homebot.plugins import load_plugin, plugin_names
from homebot.support.backoff import Backoff
from homebot.support.key_roles import note_table

DRIVERS = "homebot.drivers"

LOST_BACKOFF: Final = Backoff(first=1.0, factor=2.0, cap=15.0, late_cap=60.0, late_after=300.0, jitter=0.5)
"""After a lost connection: a device that restarts is back within seconds."""

CONNECTED_WITHIN: Final = 5.0
"""Seconds for which a command waits for a connection."""


@dataclass(frozen=True, slots=True)
class UsableDriver:
    """A driver that can be used."""

    name: str
    kind: type[Driver]
    settings: DriverSettings


def find_drivers(
    tables: Mapping[str, Mapping[str, object]], folder: Path
) -> tuple[Mapping[str, UsableDriver], tuple[str, ...]]:
    """Load all installed drivers, and those in the configuration, with paths relative to *folder*.

    Returns:
        The usable drivers by service type, and the reasons why others cannot be used, in words. Of two for one type,
        the one named in the configuration counts, or else the first by name.

    Raises:
        UsageError: A driver with a table cannot be used, or its table is invalid.
    """
    by_type: dict[str, UsableDriver] = {}
    problems = []
    for name in (*tables, *(plugin_name for plugin_name in plugin_names(DRIVERS) if plugin_name not in tables)):
        try:
            driver = _load(name, tables.get(name, {}), folder)
        except UsageError as exc:
            if name in tables:
                raise UsageError(f"drivers.{name}: {exc}") from exc
            problems.append(f"the driver {name} is not used: {exc}")
            continue
        for service_type in driver.kind.service_types:
            by_type.setdefault(full_type(service_type), driver)
    return by_type, tuple(problems)


def _load(name: str, table: Mapping[str, object], folder: Path) -> UsableDriver:
    kind = load_plugin(DRIVERS, name)
    if not issubclass(kind, Driver):
        raise PluginError(name, f"{kind.__name__} is not a Driver; derive it from {Driver.__module__}")
    note_table(f"drivers.{name}", kind.Settings, table)
    try:
        settings = kind.Settings.model_validate(table, context=in_folder(folder))
    except ValidationError as exc:
        first = exc.errors(include_url=False, include_input=False)[0]
        raise UsageError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from exc
    kind.check(settings)
    return UsableDriver(name, kind, settings)


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

    async def perform(self, command: Command) -> Collection[str] | None:
        """Carry out *command*; wait a moment for a connection in progress."""
        return await (await self._connected_driver()).perform(command)

    async def refresh(self, key: str, part: str) -> None:
        """Ask the device for the values of a part; wait as :meth:`perform`."""
        await (await self._connected_driver()).refresh(key, part)

    async def _connected_driver(self) -> Driver:
        if self._is_connecting:
            with anyio.move_on_after(CONNECTED_WITHIN):
                await self._connected.wait()
        if self._driver is None or not self.is_connected:
            raise self.not_connected()
        return self._driver

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
