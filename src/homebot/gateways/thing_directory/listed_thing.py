"""One thing of a directory: run over its own forms, and tried again when it cannot be reached."""

from __future__ import annotations

from functools import partial
from random import Random
from typing import TYPE_CHECKING

import anyio
from structlog.typing import FilteringBoundLogger

from homebot.backoff import DEVICE_BACKOFF, DEVICE_REFUSED_BACKOFF, Backoff, BackoffCounter
from homebot.clock import Clock
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, PeerError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.things.host import PublishedDriverHost
from homebot.gateways.things.thing_device import ThingDevice
from homebot.isolation import error_text, run_as
from homebot.wot import Thing

if TYPE_CHECKING:
    from homebot.gateways.things.http_port import HttpThingPort

__all__ = ["ListedThing"]

STEADY_AFTER = 60.0
"""Seconds after which a connection that ends counts as a new failure."""

LISTED_WITHIN = 5.0
"""Seconds after which a thing is published that has not answered until then."""

_FAILED = "thing_directory.thing_failed"


class ListedThing(PublishedDriverHost):
    """A thing that a directory lists. That it is listed is a note; it was heard when it answers itself.

    Args:
        thing: The thing.
        device: The same, as it is published: when it has answered, or has not for a moment.
        port: The way to it.
        devices: Where it is published.
        clock: The clock.
        log: The log of the gateway's node.
        random: The source of random numbers.
        poll_every: Seconds between two readings of what it does not push.

    Attributes:
        device: The thing as it is published.
        scope: Ends it.
    """

    def __init__(
        self,
        thing: Thing,
        device: GatewayDevice,
        port: HttpThingPort,
        devices: PublishedDevices,
        clock: Clock,
        log: FilteringBoundLogger,
        random: Random,
        poll_every: float,
    ) -> None:
        super().__init__(devices, device.key, clock, log)
        self.device = device
        self.scope = anyio.CancelScope()
        self._port = port
        self._all = devices
        self._random = random
        self._is_published = False
        self._used = ThingDevice(thing, device, port, self, poll_every)

    def describe(self, device: GatewayDevice) -> None:
        """Do nothing: the directory described it."""

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the thing can be reached, and that it was heard where it can."""
        if reachable:
            self.confirm()
        super().report_reachable(reachable=reachable, part=part)

    def confirm(self) -> None:
        """Publish that the thing itself was heard, unless it was taken away meanwhile."""
        if not self.scope.cancel_called:
            self._is_published = True
            self._all.put(self.device, "it answers")

    async def run(self, delay: float) -> None:
        """Work with the thing until :attr:`scope` is cancelled.

        Args:
            delay: Seconds to wait first, when many things are new.
        """
        with self.scope:
            async with self._port, anyio.create_task_group() as tasks:
                tasks.start_soon(self._list_in_time)
                await anyio.sleep(delay)
                await self._run_again_and_again()

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it.

        Raises:
            LinkError: The thing does not answer.
            RefusedError: It refuses.
            UnableError: It cannot do that as it is described.
        """
        await self._used.perform(command)

    async def _run_again_and_again(self) -> None:
        retries = BackoffCounter(self.clock, self._random, STEADY_AFTER)
        while True:
            retries.begin()
            failed = await self._run_once()
            self._list()
            self.report_reachable(reachable=False)
            await anyio.sleep(retries.fail(failed))

    async def _run_once(self) -> Backoff:
        """Work with the thing until that fails; return how long to wait then."""
        failed, problem = DEVICE_BACKOFF, "the connection was closed"
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(run_as, "a thing", self._used.run)
                tasks.start_soon(run_as, "a thing", partial(self._port.watch, self.confirm))
        except* LinkError as group:
            problem = error_text(group.exceptions[0])
        except* PeerError as group:
            failed, problem = DEVICE_REFUSED_BACKOFF, error_text(group.exceptions[0])
        except* Exception as group:
            failed, problem = DEVICE_REFUSED_BACKOFF, error_text(group)
            self.log.warning(_FAILED, message=f"{self.device.name}: {problem}", exc_info=group)
        self.log.info("thing_directory.thing_lost", device=self.device.key, reason=problem[:200])
        return failed

    async def _list_in_time(self) -> None:
        await anyio.sleep(LISTED_WITHIN)
        self._list()

    def _list(self) -> None:
        """Publish the thing as its directory knows it, where it has not answered yet."""
        if not self._is_published:
            self._is_published = True
            self._all.put(self.device, "the directory lists it", confirmed=False)
