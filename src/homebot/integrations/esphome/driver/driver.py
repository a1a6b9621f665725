"""The driver for ESPHome's native API: one connection to each device, over which it pushes its states."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Collection
from contextlib import ExitStack, asynccontextmanager
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar

import anyio
from anyio import to_thread
from pydantic import SecretStr

from homebot.conventions.entity_rows import Fields
from homebot.conventions.joint_message import join
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, RefusedError, UsageError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.base import Driver, DriverSettings, FoundService
from homebot.integrations.esphome.driver.settings import KEY_ADVICE, EsphomeSettings
from homebot.integrations.esphome.formats.device import EsphomeDevice
from homebot.support.ble_proxies import BleProxies

if TYPE_CHECKING:
    from homebot.integrations.esphome.driver.connection import EsphomeConnection

MAX_EVENTS = 100
"""Most events waiting to be reported; of states, only the newest of each entity waits."""

STALE_AFTER_SLEEP = 24 * 3600.0
"""Seconds of silence after which a sleepy device counts as stale; most wake up at least once a day."""


class EsphomeDriver(Driver):
    """Connects to an ESPHome device, reports its pushed states, and sends commands."""

    service_types: ClassVar[frozenset[str]] = frozenset({"_esphomelib._tcp.local."})
    Settings: ClassVar[type[DriverSettings]] = EsphomeSettings
    libraries: ClassVar[tuple[str, ...]] = ("aioesphomeapi",)
    settings: EsphomeSettings

    def __init__(self, service: FoundService, settings: DriverSettings, host: DriverHost) -> None:
        super().__init__(service, settings, host)
        self._connection: EsphomeConnection | None = None
        self._device: EsphomeDevice | None = None

    async def run(self) -> None:
        """Connect, describe the device, and report its states, until cancelled."""
        await to_thread.run_sync(import_module, "homebot.integrations.esphome.driver.connection")  # most of a second
        from homebot.integrations.esphome.driver.connection import connected  # noqa: PLC0415 - an extra

        service, (key, password) = self.service, self._secrets()
        addresses = self.settings.addresses_of(service.name, service.addresses)
        async with connected(service.name, addresses, service.port, key, password) as connection:
            device = EsphomeDevice(*await connection.describe())
            if device.left_out:
                self.host.reject(b"", f"{service.name} lists {device.left_out} entities too many; they are left out")
            self.host.describe(
                GatewayDevice(
                    self.service.key,
                    device.name or self.service.name,
                    device.parts(),
                    metadata=device.metadata,
                    identifiers=device.identifiers,
                    authenticated=key is not None,
                    area=device.area,
                    stale_after=STALE_AFTER_SLEEP if device.sleeps else 0.0,
                    sleeps=device.sleeps,
                )
            )
            self._connection, self._device = connection, device
            try:
                async with self._relaying(connection, is_owners=key is not None):
                    await StateQueue(device, self.host).relay(connection)
            finally:
                self._connection = None
        raise LinkError(f"the connection to {service.name} was lost")

    async def perform(self, command: Command) -> Collection[str]:
        """Send a command, which the native API does not acknowledge."""
        connection, device = self._connection, self._device
        if connection is None or device is None:
            raise LinkError(f"{self.service.name} is not connected")
        entity = device.entity(command.part)
        fields, along = join(
            command,
            lambda setting: entity.command(setting.capability, setting.value.plain(), setting.transition, setting.code),
        )
        connection.send(entity.component, entity.key, fields)
        return along

    @asynccontextmanager
    async def _relaying(self, connection: EsphomeConnection, *, is_owners: bool) -> AsyncIterator[None]:
        """Hand over the advertisements that the owner's device hears, inside the block."""
        proxies = self.host.service(BleProxies)  # type: ignore[type-abstract]
        with ExitStack() as stack:
            if proxies is not None and proxies.takes_found and is_owners and connection.is_bluetooth_proxy:
                from homebot.integrations.esphome.driver import bluetooth_proxy  # noqa: PLC0415 - an extra

                try:
                    await bluetooth_proxy.load_library()
                    stack.enter_context(bluetooth_proxy.relaying(connection, proxies.attached))
                except (RefusedError, UsageError) as exc:
                    self.host.reject(b"", str(exc))
            yield

    def _secrets(self) -> tuple[SecretStr | None, SecretStr | None]:
        """Return the key and the password of the device.

        The common key is used if the device announces encryption. A key of its own is always used, so that an impostor
        cannot get its commands by announcing its name without encryption. A password is only sent unencrypted to a
        device with a fixed address in the settings.
        """
        name = self.service.name
        try:
            key, password = self.settings.secrets_of(name)
        except UsageError as exc:  # they existed when the gateway started
            raise RefusedError(f"the connection to {name}", str(exc)) from exc
        encrypts = "api_encryption" in self.service.properties
        if encrypts and key is None:
            raise RefusedError(f"the connection to {name}", f"it wants encryption; {KEY_ADVICE.format(name)}")
        is_own = name in self.settings.devices
        if key is not None and not (encrypts or is_own):
            return None, None
        return key, password


class StateQueue:
    """The queue of pushed states: the newest of each entity, and the events."""

    def __init__(self, device: EsphomeDevice, host: DriverHost) -> None:
        self._device = device
        self._host = host
        self._states: dict[str, Fields] = {}
        self._events: deque[tuple[str, Fields]] = deque()
        self._filled = anyio.Event()

    async def relay(self, connection: EsphomeConnection) -> None:
        """Report states and events until the connection is lost."""
        connection.subscribe(self.put)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self.report_all)
            await connection.lost.wait()
            tasks.cancel_scope.cancel()

    def put(self, kind: str, state: Fields) -> None:
        """Queue a pushed state."""
        part = self._device.part_of(kind, state)
        if part is None:
            return
        if kind != "event":
            self._states[part] = state
        elif len(self._events) < MAX_EVENTS:
            self._events.append((part, state))
        else:
            self._host.reject(b"", f"{part} reports events faster than they can be read")
        self._filled.set()

    async def report_all(self) -> None:
        """Report queued states and events until cancelled."""
        while True:
            await self._filled.wait()
            self._filled = anyio.Event()
            states, self._states = self._states, {}
            for part, state in states.items():
                await self._report(part, state)
            while self._events:
                await self._report(*self._events.popleft())

    async def _report(self, part: str, state: Fields) -> None:
        values = self._device.entities[part].read(state)
        if values:
            await self._host.report(values, part)
