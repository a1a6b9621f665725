"""Runs the driver of one service until the service is gone, and passes commands to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Final

import anyio
from structlog.typing import FilteringBoundLogger

from homebot.backoff import DEVICE_REFUSED_BACKOFF, Backoff, BackoffCounter
from homebot.clock import Clock
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, PeerError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.drivers import Driver, FoundService
from homebot.gateways.drivers.installed_drivers import UsableDriver
from homebot.gateways.things.host import PublishedDriverHost
from homebot.isolation import error_text, first_cause, run_as

__all__ = ["DriverRunner"]

FAILED = "driver.failed"
CRASHED = "driver.crashed"

LOST_BACKOFF: Final = Backoff(first=1.0, factor=2.0, cap=15.0, late_cap=60.0, late_after=300.0, jitter=0.5)
"""After a lost connection: a device that restarts is back within seconds."""

STEADY_AFTER = 60.0
"""Seconds that a connection has to last for the back-off to start over."""

DESCRIBED_WITHIN = 5.0
"""Seconds after which a device is listed without parts if its driver has not described it yet; also how long a command
waits for a connection that is being made."""


class DriverRunner(PublishedDriverHost):
    """Runs the driver of one service, and publishes what it says.

    Args:
        driver: The driver.
        service: The service.
        devices: Where it is published.
        publish: Publishes the device: what its driver says it is, None for what DNS-SD alone knows.
        clock: The clock.
        log: The log of the gateway's node.
        random: The source of random numbers.

    Attributes:
        service: The service, as it was last found.
        problem: The reason why it is not connected, as text; empty where it is, or has not tried yet.
        needs_help: Whether a person has to do something about that, rather than wait.
    """

    def __init__(
        self,
        driver: UsableDriver,
        service: FoundService,
        devices: PublishedDevices,
        publish: Callable[[GatewayDevice | None], None],
        clock: Clock,
        log: FilteringBoundLogger,
        random: Random,
    ) -> None:
        super().__init__(devices, service.key, clock, log)
        self.service = service
        self.problem = ""
        self.needs_help = False
        self._kind = driver
        self._publish = publish
        self._random = random
        self._driver: Driver | None = None
        self._connected = anyio.Event()
        self._connecting = True
        self._attempt: anyio.CancelScope | None = None
        self._is_published = False
        self._sleeps = False

    def change(self, service: FoundService) -> None:
        """Take the current records of the service; restart the driver if host, port or TXT record changed."""
        before, self.service = self.service, service
        if _place(before) != _place(service) and self._attempt is not None:
            self._attempt.cancel()

    async def run(self) -> None:
        """Run the driver until cancelled; after a failure, wait with a growing pause and run it again."""
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._list_in_time)
            retries = BackoffCounter(self.clock, self._random, STEADY_AFTER)
            while True:
                retries.begin()
                failed = await self._run_once()
                if failed is None:
                    retries.succeed()
                    continue
                with anyio.CancelScope() as self._attempt:
                    await anyio.sleep(retries.fail(failed))

    async def perform(self, command: Command) -> None:
        """Carry *command* out; it waits a moment for a connection that is being made.

        Raises:
            LinkError: There is no connection.
            PeerError: The device refuses.
        """
        if self._connecting:
            with anyio.move_on_after(DESCRIBED_WITHIN):
                await self._connected.wait()
        if self._driver is None or not self._connected.is_set():
            raise LinkError(f"{self.service.name} is not connected" + (f": {self.problem}" if self.problem else ""))
        await self._driver.perform(command)

    def describe(self, device: GatewayDevice) -> None:
        """Publish what the device is, under the key of its service; it is connected now."""
        self._is_published, self._sleeps = True, device.sleeps
        self.problem, self.needs_help = "", False
        self._publish(replace(device, key=self.service.key))
        self._connected.set()
        self._connecting = False
        self.report_reachable(reachable=True)

    async def _run_once(self) -> Backoff | None:
        """Run the driver until it fails; return the back-off to wait, or None to run it again at once."""
        self._connecting, self._connected = True, anyio.Event()
        failed: Backoff | None = None
        with anyio.CancelScope() as self._attempt:
            try:
                self._driver = driver = self._kind.kind(self.service, self._kind.settings, self)
                await run_as(f"the driver {self._kind.name}", driver.run)
                failed, self.problem = LOST_BACKOFF, "the connection was closed"
            except* LinkError as group:
                failed, self.problem = LOST_BACKOFF, str(first_cause(group))
            except* PeerError as group:
                failed, self.problem = DEVICE_REFUSED_BACKOFF, str(first_cause(group))
                self._log_failure(FAILED)
            except* Exception as group:  # noqa: BLE001 - one device's driver must not end the others
                failed, self.problem = DEVICE_REFUSED_BACKOFF, error_text(group)
                self._log_failure(CRASHED, exc_info=group)
        self._driver = None
        self.needs_help = failed is DEVICE_REFUSED_BACKOFF
        self._end_attempt()
        return failed

    def _end_attempt(self) -> None:
        self._connecting = False
        self._connected.set()  # nobody is to wait for it any more
        self._connected = anyio.Event()
        self._list()
        self.report_reachable(reachable=None if self._sleeps else False)

    def _log_failure(self, event: str, exc_info: BaseException | None = None) -> None:
        message = f"{self.service.name} ({self.service.host}): {self.problem}"
        self.log.warning(
            event, message=message, device=self.service.key, **({"exc_info": exc_info} if exc_info else {})
        )

    async def _list_in_time(self) -> None:
        await anyio.sleep(DESCRIBED_WITHIN)
        self._list()

    def _list(self) -> None:
        if not self._is_published:
            self._is_published = True
            self._publish(None)


def _place(service: FoundService) -> tuple[object, ...]:
    return service.host, service.port, dict(service.properties)
