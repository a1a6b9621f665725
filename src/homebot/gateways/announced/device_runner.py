"""Works with one device again and again: connects, waits with a growing pause where that fails, and connects again."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from itertools import islice
from typing import Final, Protocol

import anyio
from structlog.typing import FilteringBoundLogger

from homebot.clock import Clock
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, PeerError, WireError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.support.backoff import DEVICE_REFUSED_BACKOFF, WRONG_ANSWER_BACKOFF, Backoff, BackoffCounter
from homebot.support.isolation import error_text, first_cause, run_as

__all__ = ["LISTED_WITHIN", "MAX_PROBLEMS", "DeviceRunner", "DriverHost", "PublishedDevice", "problems_of"]

FAILED = "device.failed"
CRASHED = "device.crashed"

LISTED_WITHIN: Final = 5.0
"""Seconds after which a device is listed as it is known from elsewhere if it has not answered yet."""

STEADY_AFTER: Final = 60.0
"""Seconds that a connection has to last for the back-off to start over."""

SLEEPER_WITHIN: Final = 5.0
"""Longest pause between two attempts to connect to a device that sleeps: it is awake for some seconds only."""

MAX_PROBLEMS: Final = 20
"""Devices in the list of problems."""


class DriverHost(Protocol):
    """The interface that a gateway offers to the driver of one service."""

    clock: Clock
    log: FilteringBoundLogger

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device, once it is known and on each change.

        Args:
            device: The device; its key is that of the service. Facts from DNS-SD are added by the gateway.
        """

    def describe_behind(self, devices: Iterable[GatewayDevice]) -> None:
        """Publish the descriptions of the devices that the device connects, in place of those before.

        They can be reached if the device can; each has a key of its own.
        """

    async def report(self, values: Mapping[str, PlainValue], part: str = "", key: str = "") -> None:
        """Publish a report of a part, in the units of the vocabulary; values that it cannot have are refused.

        Args:
            key: The key of a device behind the device; empty for the device itself.
        """

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device with all behind it, or one of its parts, can be reached.

        The gateway does so for the connection.
        """

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the subscribers of its address."""

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""


class PublishedDevice:
    """One device of a gateway; it is a :class:`DriverHost`."""

    def __init__(
        self, devices: PublishedDevices, key: str, behind: MutableMapping[str, GatewayDevice] | None = None
    ) -> None:
        node = devices.gateway.node
        self.clock = node.graph.clock
        self.log = node.log
        self.key = key
        self._devices = devices
        self._behind = {} if behind is None else behind

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device."""
        self._devices.put(device, "it described itself")

    def describe_behind(self, devices: Iterable[GatewayDevice]) -> None:
        """Publish the descriptions of the devices behind it that are new or changed, and remove the others."""
        described = {one.key: one for one in devices}
        for key in self._behind.keys() - described.keys():
            del self._behind[key]
            self._devices.remove(key, f"{self.key} has it no more")
        for key, device in described.items():
            if self._behind.get(key) != device:
                self._behind[key] = device
                self._devices.put(device, f"{self.key} described it")
            self._devices.report_reachable(key, reachable=True)

    async def report(self, values: Mapping[str, PlainValue], part: str = "", key: str = "") -> None:
        """Publish the reported values of a part, of the device or of the one behind it with that *key*."""
        await self._devices.report(key or self.key, values, part)

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device with all behind it, or one of its parts, can be reached."""
        self._devices.report_reachable(self.key, part, reachable=reachable)
        for key in () if part else self._behind:
            self._devices.report_reachable(key, reachable=reachable)

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the listeners of its address."""
        await self._devices.deliver_raw(self.key, payload)

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""
        self._devices.reject(self.key, payload, why)


class DeviceRunner(PublishedDevice, ABC):
    """Works with one device until it is stopped, and publishes whether it can be reached.

    Attributes:
        problem: The reason why it is not connected, as text; empty if it is, or has not tried yet.
        needs_help: Whether a person has to do something about that, rather than wait.
        sleeps: Whether a lost connection says nothing: it leaves the network to save its battery.
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
            LinkError: It cannot be connected to, or the connection was lost.
            PeerError: It broke the rules of its protocol, or refuses homebot; the message gives the remedy.
        """

    @abstractmethod
    def list_unheard(self) -> None:
        """Publish the device as it is known from elsewhere; called if it has not answered yet."""

    def on_answer(self) -> None:
        """Record that the device answers, and is published."""
        self._is_listed = True
        self.problem, self.needs_help = "", False

    def not_connected(self) -> LinkError:
        """Return the error of a command that comes while there is no connection."""
        return LinkError(f"{self.name} is not connected" + (f": {self.problem}" if self.problem else ""))

    def on_end(self) -> None:
        """Publish that the connection ended."""
        self._list()
        self.report_reachable(reachable=None if self.sleeps else False)

    async def run(self) -> None:
        """Work with the device until it is stopped; after a failure, wait with a growing pause and try again."""
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
        """Connect anew, at once."""
        self._attempt.cancel()
        self._pause.cancel()

    def wake(self) -> None:
        """Try again at once if the next attempt is awaited: the device gave a sign of life."""
        self._pause.cancel()

    def stop(self) -> None:
        """End :meth:`run`; nothing is published after that."""
        self._work.cancel()

    @property
    def is_stopped(self) -> bool:
        """True after :meth:`stop`."""
        return self._work.cancel_called

    async def _try(self) -> Backoff | None:
        """Work until that fails; return the back-off to wait, or None to try again at once."""
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
            except* Exception as group:  # the work with one device must not end that with others
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
    """Return the problems of devices that need a person's help, as text; :data:`MAX_PROBLEMS` at most."""
    return islice((f"{one.name}: {one.problem}" for one in runners if one is not None and one.needs_help), MAX_PROBLEMS)
