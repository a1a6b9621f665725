"""The connection to one device: kept, and made again with growing pauses after failures."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from itertools import islice
from typing import Final, TypeVar

import anyio
from structlog.typing import FilteringBoundLogger

from homebot.clock import Clock
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, PeerError, WireError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.support.backoff import DEVICE_REFUSED_BACKOFF, WRONG_ANSWER_BACKOFF, Backoff, BackoffCounter
from homebot.support.isolation import error_text, first_cause, run_as

FAILED = "device.failed"
CRASHED = "device.crashed"

LISTED_WITHIN: Final = 5.0
"""Seconds after which a device that has not answered is listed with what is known from elsewhere."""

STEADY_AFTER: Final = 60.0
"""Seconds for which a connection must last to reset the back-off."""

SLEEPER_WITHIN: Final = 5.0
"""Longest pause between attempts to connect to a sleepy device, which is awake for a few seconds only."""

MAX_PROBLEMS: Final = 20
"""Most devices in the list of problems."""


ServiceT = TypeVar("ServiceT")


class DriverHost:
    """The gateway as the driver of one device sees it."""

    def __init__(
        self, devices: PublishedDevices, key: str, behind: MutableMapping[str, GatewayDevice] | None = None
    ) -> None:
        node = devices.gateway.node
        self.clock: Clock = node.graph.clock
        self.log: FilteringBoundLogger = node.log
        self.key = key
        self._devices = devices
        self._behind = {} if behind is None else behind

    def service(self, kind: type[ServiceT]) -> ServiceT | None:
        """Return the running service of the host of the class *kind*, or None."""
        return self._devices.gateway.context.service(kind)

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device, once it is known and on each change.

        Args:
            device: Has the key of the service; the gateway adds the facts from DNS-SD.
        """
        self._devices.put(device, "it described itself")

    def describe_behind(self, devices: Iterable[GatewayDevice]) -> None:
        """Publish the descriptions of all devices behind this one, each with a key of its own.

        They replace the earlier ones, and can be reached if the device can.
        """
        described = {device.key: device for device in devices}
        for key in self._behind.keys() - described.keys():
            del self._behind[key]
            self._devices.remove(key, f"{self.key} has it no more")
        for key, device in described.items():
            if self._behind.get(key) != device:
                self._behind[key] = device
                self._devices.put(device, f"{self.key} described it")
            self._devices.report_reachable(key, reachable=True)

    async def report(self, values: Mapping[str, PlainValue], part: str = "", key: str = "") -> None:
        """Publish a report of a part, in the units of the vocabulary; values that do not fit the part are refused.

        Args:
            key: The key of a device behind this one; empty for the device itself.
        """
        await self._devices.report(key or self.key, values, part)

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device and all behind it, or one of its parts, can be reached.

        The gateway itself does so when the connection is made or lost.
        """
        self._devices.report_reachable(self.key, part, reachable=reachable)
        for key in () if part else self._behind:
            self._devices.report_reachable(key, reachable=reachable)

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the subscribers of its address."""
        await self._devices.deliver_raw(self.key, payload)

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks its protocol, and log it at a limited rate."""
        self._devices.reject(self.key, payload, why)


class DeviceRunner(DriverHost, ABC):
    """Keeps the connection to one device until stopped, and publishes whether the device can be reached.

    Attributes:
        problem: Why it is not connected, in words; empty if it is, or has not tried yet.
        needs_help: Whether a person has to act on the problem, rather than wait.
        sleeps: Whether the device leaves the network to save its battery, so that a lost connection means nothing.
    """

    def __init__(
        self,
        name: str,
        key: str,
        devices: PublishedDevices,
        lost_backoff: Backoff,
        behind: MutableMapping[str, GatewayDevice] | None = None,
    ) -> None:
        super().__init__(devices, key, behind)
        self.name = name
        self.problem = ""
        self.needs_help = False
        self.sleeps = False
        self._lost_backoff = lost_backoff
        self._random = devices.gateway.random
        self._is_listed = False
        self._work = anyio.CancelScope()
        self._attempt, self._pause = anyio.CancelScope(), anyio.CancelScope()

    @abstractmethod
    async def work(self) -> None:
        """Connect, publish the device's values, and call :meth:`on_answer` when it answers, until cancelled.

        Raises:
            LinkError: It cannot be reached, or the connection was lost.
            PeerError: It broke its protocol, or refuses homebot; the message gives the remedy.
        """

    @abstractmethod
    def list_unheard(self) -> None:
        """Publish the device as known from elsewhere; called if it has not answered yet."""

    def on_answer(self) -> None:
        """Record that the device has answered and is published."""
        self._is_listed = True
        self.problem, self.needs_help = "", False

    def not_connected(self) -> LinkError:
        """Return the error for a command without a connection."""
        return LinkError(f"{self.name} is not connected" + (f": {self.problem}" if self.problem else ""))

    def on_end(self) -> None:
        """Publish the end of the connection."""
        self._list()
        self.report_reachable(reachable=None if self.sleeps else False)

    async def run(self) -> None:
        """Connect and work until stopped, with growing pauses after failures."""
        with self._work:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._list_in_time)
                retries = BackoffCounter(self.clock, self._random, STEADY_AFTER)
                while True:
                    retries.begin()
                    failed = await self._try()
                    if failed is None:
                        retries.succeed()
                        continue
                    pause = retries.fail(failed)
                    with anyio.CancelScope() as self._pause:
                        await anyio.sleep(min(pause, SLEEPER_WITHIN) if self.sleeps and not self.needs_help else pause)

    def restart(self) -> None:
        """Connect again at once."""
        self._attempt.cancel()
        self._pause.cancel()

    def wake(self) -> None:
        """End the pause before the next attempt: the device gave a sign of life."""
        self._pause.cancel()

    def stop(self) -> None:
        """End :meth:`run` without publishing anything."""
        self._work.cancel()

    @property
    def is_stopped(self) -> bool:
        """True after :meth:`stop`."""
        return self._work.cancel_called

    async def _try(self) -> Backoff | None:
        """Work until a failure; return its back-off, or None to try again at once."""
        failed: Backoff | None = None
        with anyio.CancelScope() as self._attempt:
            try:
                await run_as(self.name, self.work)
                failed, self.problem = self._lost_backoff, "the connection was closed"
            except* LinkError as group:
                failed, self.problem = self._lost_backoff, str(first_cause(group))
            except* PeerError as group:
                cause = first_cause(group)
                failed = WRONG_ANSWER_BACKOFF if isinstance(cause, WireError) else DEVICE_REFUSED_BACKOFF
                self.problem = str(cause)
                self._devices.engine.quarantine.log_limited(FAILED, f"{self.name}: {self.problem}", self.key)
            except* Exception as group:  # a failure with one device must not affect the others
                failed, self.problem = DEVICE_REFUSED_BACKOFF, error_text(group)
                self.log.warning(CRASHED, message=f"{self.name}: {self.problem}", device=self.key, exc_info=group)
        self.needs_help = failed is not None and failed is not self._lost_backoff
        if not self.is_stopped:
            self.on_end()
        return failed

    async def _list_in_time(self) -> None:
        await anyio.sleep(LISTED_WITHIN)
        self._list()

    def _list(self) -> None:
        if not self._is_listed:
            self._is_listed = True
            self.list_unheard()


def problems_of(runners: Iterable[DeviceRunner | None]) -> Iterator[str]:
    """Return the problems that need a person's help, in words; at most :data:`MAX_PROBLEMS`."""
    return islice(
        (f"{runner.name}: {runner.problem}" for runner in runners if runner is not None and runner.needs_help),
        MAX_PROBLEMS,
    )
