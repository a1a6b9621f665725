"""Simulated ESPHome devices for tests, and drivers of them."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from tests.gateways.drivers.driver_host import KeepingHost
from tests.integrations.esphome.simulated.device import EsphomeServedDevice

from homebot.errors import HomebotError
from homebot.gateways.base import GatewayContext
from homebot.gateways.drivers.base import FoundService
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.esphome.driver import EsphomeDriver, EsphomeSettings

KEY = "mBqUHGEr8Ie7OWkgkB8cJ0hBMwgzEjzlyuqOUyO2hZk="
OTHER_KEY = "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAE="


def simulated(kind: str, told: list[str], *, key: str = "", password: str = "") -> EsphomeServedDevice:
    """Return a device of a *kind*; *told* gets its commands."""
    info = SimulatedDeviceInfo(home="home", kind=kind, device_id="hall", service_type="lights", room="Hall")
    device = EsphomeServedDevice(info, told.append, key=key, password=password)
    device.begin(DeviceState(text="off"), has_power=True)
    return device


def service_of(device: EsphomeServedDevice) -> FoundService:
    """Return how a device that listens is found."""
    name, kind = device.name, "_esphomelib._tcp.local."
    return FoundService(f"{name}.{kind}", name, kind, f"{name}.local.", device.port, (device.host,), device.txt)


@asynccontextmanager
async def living(device: EsphomeServedDevice) -> AsyncIterator[None]:
    """Let a simulated device live inside the block."""
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(device.live)
        await device.listening.wait()
        yield
        tasks.cancel_scope.cancel()


class DriverRun:
    """A driver of a device that listens, while it runs.

    Attributes:
        host: What it said.
        driver: The driver.
        ended: The error with which it ended; None while it runs.
    """

    def __init__(
        self, service: FoundService, settings: EsphomeSettings | None = None, services: GatewayContext | None = None
    ) -> None:
        self.host = KeepingHost(services)
        self.driver = EsphomeDriver(service, settings or EsphomeSettings(), self.host)
        self.ended: HomebotError | None = None

    async def run(self) -> None:
        try:
            await self.driver.run()
        except HomebotError as exc:
            self.ended = exc
            self.host.report_reachable(reachable=False)

    async def until_reported(self) -> None:
        """Wait for the first state, or the end."""
        await self.host.until(lambda: bool(self.host.events) or self.ended is not None)
        assert self.ended is None, self.ended

    async def failure(self) -> HomebotError:
        """Return the error with which it ends."""
        await self.host.until(lambda: self.ended is not None)
        assert self.ended is not None
        return self.ended


@asynccontextmanager
async def driven(
    service: FoundService, settings: EsphomeSettings | None = None, services: GatewayContext | None = None
) -> AsyncIterator[DriverRun]:
    """Let a driver run inside the block."""
    run = DriverRun(service, settings, services)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(run.run)
        yield run
        tasks.cancel_scope.cancel()
