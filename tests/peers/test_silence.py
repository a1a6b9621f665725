"""A device that vanishes without closing its connection is noticed by its driver, whatever that speaks.

``pytest tests/peers/test_silence.py -s`` prints how long it took; the README has the figures.
"""

import json
import signal
import sys

import anyio
import pytest
from tests.gateways.drivers.driver_host import KeepingHost
from tests.peers.network import Lan, Machine, Program

from homebot.errors import LinkError
from homebot.gateways.drivers import Driver, FoundService
from homebot.integrations.esphome.driver import EsphomeDriver
from homebot.integrations.shelly.driver import ShellyDriver
from homebot.integrations.things.driver import ThingDriver
from homebot.integrations.wled.driver import WledDriver
from homebot.support.isolation import first_cause

DRIVERS: dict[str, tuple[type[Driver], str]] = {
    "esphome": (EsphomeDriver, "_esphomelib._tcp.local."),
    "shelly": (ShellyDriver, "_shelly._tcp.local."),
    "thing": (ThingDriver, "_wot._tcp.local."),
    "wled": (WledDriver, "_wled._tcp.local."),
}
DEVICES = "tests.peers.silent_devices"
HANGS_AFTER = 150.0
"""Far more than any driver needs on the slowest machine."""


class Watched:
    """One driver of one device, and when it noticed that the device is gone."""

    def __init__(self, name: str, address: str, port: int) -> None:
        kind, service_type = DRIVERS[name]
        service = FoundService(f"Hall.{service_type}", "Hall", service_type, "hall.local.", port, (address,))
        self.name = name
        self.host = KeepingHost()
        self.driver = kind(service, kind.Settings(), self.host)
        self.noticed_at = 0.0
        self.noticed = anyio.Event()

    async def run(self) -> None:
        try:
            await self.driver.run()
        except (LinkError, BaseExceptionGroup) as exc:
            cause = first_cause(exc) if isinstance(exc, BaseExceptionGroup) else exc
            if not isinstance(cause, LinkError):
                raise
            self.noticed_at = anyio.current_time()
            self.noticed.set()


@pytest.mark.parametrize("how", ["its cable is pulled out", "it hangs"])
async def test_a_device_that_says_nothing_any_more_is_noticed(how: str, lan: Lan, hub: Machine) -> None:
    del hub
    machine = lan.machine("dev")
    async with machine.program(sys.executable, "-m", DEVICES, machine.address) as program:
        printed = await program.prints("ports")
        ports: dict[str, int] = json.loads(printed.partition("ports")[2].splitlines()[0])
        watched = [Watched(name, machine.address, port) for name, port in sorted(ports.items())]
        async with anyio.create_task_group() as tasks:
            for one in watched:
                tasks.start_soon(one.run)
            for one in watched:
                await one.host.until(lambda one=one: bool(one.host.events))  # type: ignore[misc]
            await anyio.sleep(2)  # so that no question is on its way
            silent_since = anyio.current_time()
            silence(lan, machine, program, how)
            with anyio.fail_after(HANGS_AFTER):
                for one in watched:
                    await one.noticed.wait()
        program.end(signal.SIGCONT)
    for one in watched:
        print(  # noqa: T201 - the README has the figures
            f"{how}: {one.name} is missed after {one.noticed_at - silent_since:.1f} s"
        )


def silence(lan: Lan, machine: Machine, program: Program, how: str) -> None:
    if how == "it hangs":
        program.end(signal.SIGSTOP)
    else:
        lan.unplug(machine)
