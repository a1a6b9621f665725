"""A device that leaves in the middle of a command: the caller gets an error, and the next run reaches it again."""

from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

import anyio
import pytest
from anyio.abc import SocketAttribute, SocketStream
from tests.gateways.drivers.driver_host import KeepingHost, command, found
from tests.integrations.esphome.simulated.device import EsphomeServedDevice
from tests.integrations.shelly.simulated.web_device import ServedShelly
from tests.integrations.wled.simulated.web_device import ServedWled
from tests.patience import PATIENCE

from homebot.errors import LinkError
from homebot.gateways.drivers.base import Driver, DriverSettings, FoundService
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.esphome.driver import EsphomeDriver, EsphomeSettings
from homebot.integrations.shelly.driver import ShellyDriver, ShellyDriverSettings
from homebot.integrations.wled.driver import WledDriver


class Cable:
    """What connects homebot and a device; it can be cut when the next data comes from homebot."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._streams: list[SocketStream] = []
        self.is_weak = False

    async def serve(self, client: SocketStream) -> None:
        async with client, await anyio.connect_tcp("127.0.0.1", self._port) as device:
            ends = [client, device]
            self._streams += ends
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._forward, device, client)
                await self._forward(client, device, is_checked=True)
            self._streams = [one for one in self._streams if one not in ends]

    async def _forward(self, source: SocketStream, target: SocketStream, *, is_checked: bool = False) -> None:
        try:
            async for data in source:
                if is_checked and self.is_weak:
                    await self._cut()
                    return
                await target.send(data)
            await target.aclose()
        except (anyio.BrokenResourceError, anyio.ClosedResourceError):
            await source.aclose()
            await target.aclose()

    async def _cut(self) -> None:
        for stream in tuple(self._streams):
            await stream.aclose()


@dataclass(frozen=True)
class Kind:
    """A kind of device.

    Attributes:
        part: The part that is commanded.
        device: Makes one.
        driver: Makes its driver, for a port.
        answers: Whether it answers commands; else a caller cannot know that one was lost.
    """

    part: str
    device: Callable[[list[str]], ServedDevice]
    driver: Callable[[ServedDevice, int, KeepingHost], Driver]
    answers: bool


def lamp() -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall")


def shelly(device: ServedDevice, port: int, host: KeepingHost) -> Driver:
    del device
    return ShellyDriver(found("_shelly._tcp.local.", port, gen="3"), ShellyDriverSettings(), host)


def wled(device: ServedDevice, port: int, host: KeepingHost) -> Driver:
    del device
    return WledDriver(found("_wled._tcp.local.", port), DriverSettings(), host)


def esphome(device: ServedDevice, port: int, host: KeepingHost) -> Driver:
    assert isinstance(device, EsphomeServedDevice)
    name, kind = device.name, "_esphomelib._tcp.local."
    service = FoundService(f"{name}.{kind}", name, kind, f"{name}.local.", port, ("127.0.0.1",), device.txt)
    return EsphomeDriver(service, EsphomeSettings(), host)


KINDS = {
    "shelly": Kind("light:0", lambda told: ServedShelly(lamp(), told.append), shelly, answers=True),
    "wled": Kind("", lambda told: ServedWled(lamp(), told.append), wled, answers=True),
    "esphome": Kind("light_lamp", lambda told: EsphomeServedDevice(lamp(), told.append), esphome, answers=False),
}


@asynccontextmanager
async def served(device: ServedDevice) -> AsyncIterator[int]:
    """Serve *device* inside the block, on the port that is yielded."""
    async with anyio.create_task_group() as tasks:
        if isinstance(device, EsphomeServedDevice):
            tasks.start_soon(device.serve)
            await device.listening.wait()
            yield device.port
        else:
            assert isinstance(device, ServedShelly | ServedWled)
            await tasks.start(device.serve)
            yield device.server.port
        tasks.cancel_scope.cancel()


class Run:
    """One run of a driver, and the error with which it ended."""

    def __init__(self, driver: Driver, host: KeepingHost) -> None:
        self.driver = driver
        self.host = host
        self.error: Exception | None = None

    async def run(self) -> None:
        try:
            await self.driver.run()
        except LinkError as exc:
            self.error = exc
            self.host.report_reachable(reachable=False)

    async def until_reported(self, part: str) -> None:
        await self.host.until(lambda: (part, "on_off") in self.host.values)


@pytest.mark.parametrize("name", sorted(KINDS))
async def test_a_device_that_leaves_in_the_middle_of_a_command_is_a_lost_link_and_is_met_again(name: str) -> None:
    kind, told = KINDS[name], list[str]()
    device = kind.device(told)
    device.begin(DeviceState(text="off", brightness=0.4, kelvin=2700), has_power=True)
    async with AsyncExitStack() as stack:
        cable = Cable(await stack.enter_async_context(served(device)))
        listener = await stack.enter_async_context(await anyio.create_tcp_listener(local_host="127.0.0.1"))
        port: int = listener.extra(SocketAttribute.local_port)  # noqa: S610 - no Django
        tasks = await stack.enter_async_context(anyio.create_task_group())
        tasks.start_soon(listener.serve, cable.serve)

        def start() -> Run:
            host = KeepingHost()
            run = Run(kind.driver(device, port, host), host)
            tasks.start_soon(run.run)
            return run

        first = start()
        await first.until_reported(kind.part)
        cable.is_weak = True
        if kind.answers:
            with pytest.raises(LinkError, match=r"the connection (to \S+ )?was (lost|closed)"):
                await first.driver.perform(command(kind.part, "on_off", True))
        else:
            await first.driver.perform(command(kind.part, "on_off", True))
        await first.host.until(lambda: first.error is not None)
        with pytest.raises(LinkError, match="is not connected"):
            await first.driver.perform(command(kind.part, "on_off", True))
        assert told == []

        cable.is_weak = False
        again = start()
        await again.until_reported(kind.part)
        await again.driver.perform(command(kind.part, "on_off", True))
        with anyio.fail_after(PATIENCE):
            while told != ["on"]:  # noqa: ASYNC110 - a device tells nobody what it was told
                await anyio.sleep(0.01)
        assert again.error is None
        tasks.cancel_scope.cancel()
