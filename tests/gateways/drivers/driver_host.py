"""A gateway as drivers see it, which keeps what they say."""

from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from contextlib import asynccontextmanager
from typing import TypeVar

import anyio
from tests.gateways.served import served
from tests.patience import PATIENCE
from tests.simulated.http.served_web_device import ServedWebDevice

from homebot.clock import Clock, LoopClock
from homebot.devices.command_messages import Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue, Value
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice, can_report
from homebot.gateways.base import GatewayContext
from homebot.gateways.drivers.base import Driver, FoundService
from homebot.support.logger import get_logger

DriverT = TypeVar("DriverT", bound=Driver)
ServiceT = TypeVar("ServiceT")


class KeepingHost(DriverHost):
    """Keeps the device, its values by part and capability, its raw messages, and what was rejected."""

    def __init__(self, services: GatewayContext | None = None) -> None:
        self.services = services or GatewayContext()
        self.clock: Clock = LoopClock()
        self.log = get_logger()
        self.devices: list[GatewayDevice] = []
        self.behind: dict[str, GatewayDevice] = {}
        self.values: dict[tuple[str, str], PlainValue] = {}
        self.events: list[tuple[str, str, PlainValue]] = []
        self.refused: list[tuple[str, str, PlainValue]] = []
        self.raw: list[bytes] = []
        self.rejected: list[str] = []
        self._changed = anyio.Event()

    @property
    def device(self) -> GatewayDevice:
        return self.devices[-1]

    def service(self, kind: type[ServiceT]) -> ServiceT | None:
        return self.services.service(kind)

    def describe(self, device: GatewayDevice) -> None:
        self.devices.append(device)
        self._change()

    def describe_behind(self, devices: Iterable[GatewayDevice]) -> None:
        self.behind = {one.key: one for one in devices}
        self._change()

    async def report(self, values: Mapping[str, PlainValue], part: str = "", key: str = "") -> None:
        device = self.behind[key] if key else self.device
        (described,) = (one for one in device.parts if one.id == part)
        for name, value in values.items():
            if not can_report(described, name, value):
                self.refused.append((part, name, value))
                continue
            self.values[part, name] = value
            self.events.append((part, name, value))
        self._change()

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        self.values[part, "reachable"] = reachable
        self._change()

    async def deliver_raw(self, payload: bytes) -> None:
        self.raw.append(payload)

    def reject(self, payload: bytes, why: str) -> None:
        del payload
        self.rejected.append(why)
        self._change()

    async def until(self, is_so: Callable[[], bool]) -> None:
        """Wait until what it keeps fulfils a condition."""
        with anyio.fail_after(PATIENCE):
            while not is_so():
                self._changed = anyio.Event()
                await self._changed.wait()

    def _change(self) -> None:
        self._changed.set()


def found(service_type: str, port: int, **properties: str) -> FoundService:
    """Return a service on loopback."""
    return FoundService(f"Hall.{service_type}", "Hall", service_type, "hall.local.", port, ("127.0.0.1",), properties)


def command(
    part: str, capability: str, value: PlainValue, transition: float = 0.0, key: str = "Hall._shelly._tcp.local."
) -> Command:
    return Command(key=key, part=part, capability=capability, value=Value.of(value), transition=transition)


def night(part: str) -> Command:
    """The command of a lamp that shall shine faintly and warmly."""
    also = (Setting.of("color_temperature", 2700.0), Setting.of("on_off", True))
    return command(part, "level", 3.0).model_copy(update={"also": also})


@asynccontextmanager
async def driven(
    device: ServedWebDevice, make: Callable[[int, KeepingHost], DriverT], *reported: tuple[str, str]
) -> AsyncIterator[tuple[KeepingHost, DriverT]]:
    """Run the driver of a served device inside the block, from the report of its first value, or of these, on."""
    host = KeepingHost()
    async with served(device):
        driver = make(device.server.port, host)
        async with running(driver):
            await host.until(lambda: bool(host.values) and {*reported} <= host.values.keys())
            yield host, driver


@asynccontextmanager
async def running(driver: Driver) -> AsyncIterator[None]:
    """Run a driver inside the block."""
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(driver.run)
        yield
        tasks.cancel_scope.cancel()
