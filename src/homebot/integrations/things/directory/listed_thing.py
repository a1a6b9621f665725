"""One thing of a directory: used through its own forms, with retries when it cannot be reached."""

from __future__ import annotations

from functools import partial

import anyio

from homebot.devices.gateway_messages import Command
from homebot.gateways.announced.device_runner import DeviceRunner
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.http_client import TIME_LIMIT
from homebot.integrations.things.formats.thing import Thing
from homebot.integrations.things.http.http_port import HttpThingPort
from homebot.integrations.things.http.thing_device import ThingDevice
from homebot.support.backoff import DEVICE_BACKOFF
from homebot.support.isolation import run_as


class ListedThing(DeviceRunner):
    """A thing listed by a directory, confirmed when it answers itself.

    Args:
        device: Its device, which is published once it has answered, or has failed to for a moment.
        connecting: The limit of concurrent connection attempts.
    """

    def __init__(
        self,
        thing: Thing,
        device: GatewayDevice,
        port: HttpThingPort,
        devices: PublishedDevices,
        *,
        poll_every: float,
        connecting: anyio.CapacityLimiter,
    ) -> None:
        super().__init__(device.name, device.key, devices, DEVICE_BACKOFF)
        self._device = device
        self._port = port
        self._connecting = connecting
        self._answered = anyio.Event()
        self._thing = ThingDevice(thing, device, port, self, poll_every)

    async def run(self) -> None:
        """Work with the thing until stopped."""
        async with self._port:
            await super().run()

    async def work(self) -> None:
        """Use the thing, and check at intervals whether it is still there."""
        self._answered = anyio.Event()
        async with anyio.create_task_group() as tasks:
            async with self._connecting:
                tasks.start_soon(run_as, "a thing", self._thing.run)
                with anyio.move_on_after(TIME_LIMIT):
                    await self._answered.wait()
            tasks.start_soon(run_as, "a thing", partial(self._port.watch, self.confirm))

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        await self._thing.perform(command)

    def describe(self, device: GatewayDevice) -> None:
        """Do nothing: the directory described it."""

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the thing can be reached, and if so, that it was heard."""
        if reachable:
            self.confirm()
        super().report_reachable(reachable=reachable, part=part)

    def confirm(self) -> None:
        """Publish that the thing itself was heard, unless it has been removed."""
        self._answered.set()
        if not self.is_stopped:
            self.on_answer()
            self._devices.put(self._device, "it answers")

    def list_unheard(self) -> None:
        """Publish the thing as known from its directory."""
        self._devices.put(self._device, "the directory lists it", confirmed=False)
