"""The contract of drivers; the plug-in group is ``homebot.drivers``.

DNS-SD announces a device and its address; a driver connects to it, describes its capabilities, reports its
states and sends it commands. There is one driver object for each found service, and it knows nothing of others.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import ClassVar, Final, Protocol, TypeVar

from pydantic import BaseModel, ConfigDict
from structlog.typing import FilteringBoundLogger

from homebot.clock import Clock
from homebot.conventions.dns_sd.found_service import FoundService
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import LinkError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.support.extras import check_extra

__all__ = ["Driver", "DriverHost", "DriverSession", "DriverSettings", "FoundService", "SessionDriver", "first_answer"]

Answer = TypeVar("Answer")

MAX_ASKED: Final = 4
"""Addresses that are asked; a device has an IPv4 address and up to three of IPv6."""


class DriverSettings(BaseModel):
    """The table of a driver, ``[gateways.mdns.drivers.NAME]``; a driver's own model derives from it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def check_secrets(self) -> None:
        """Read the secrets that it names, if any, before anything is started.

        Raises:
            UsageError: One cannot be read; names the key.
        """


class DriverHost(Protocol):
    """The interface that a gateway offers to the driver of one service.

    Attributes:
        clock: The clock.
        log: The log of the gateway's node.
    """

    clock: Clock
    log: FilteringBoundLogger

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device, once it is known and on each change.

        Args:
            device: The device; its key is that of the service. Facts from DNS-SD are added by the gateway.
        """

    async def report(self, values: Mapping[str, PlainValue], part: str = "") -> None:
        """Publish a report of a part, in the units of the vocabulary; values that it cannot have are refused."""

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device, or one of its parts, can be reached; the gateway does so for the connection."""

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the subscribers of its address."""

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""


class Driver(ABC):
    """A driver for one service.

    It is made anew for each try to connect: after a failure, and when host, port or TXT record of the service have
    changed.

    Args:
        service: The service.
        settings: The driver's table, checked; an instance of :attr:`Settings`.
        host: Its gateway.

    Attributes:
        service_types: The DNS-SD service types that it is for: ``_shelly._tcp.local.``
        Settings: The model of its table.
        libraries: The top-level modules that it needs of homebot's extra ``mdns``.
    """

    service_types: ClassVar[frozenset[str]]
    Settings: ClassVar[type[DriverSettings]] = DriverSettings
    libraries: ClassVar[tuple[str, ...]] = ()

    def __init__(self, service: FoundService, settings: DriverSettings, host: DriverHost) -> None:
        self.service = service
        self.settings = settings
        self.host = host

    @classmethod
    def check(cls, settings: DriverSettings) -> None:
        """Look for the needs of the driver before anything is started: its libraries, and its secrets.

        Raises:
            UsageError: It could not work; the message gives the remedy.
        """
        check_extra("it", "mdns", *cls.libraries)
        settings.check_secrets()

    @abstractmethod
    async def run(self) -> None:
        """Connect, describe the device, and report its states, until cancelled.

        The gateway runs it again after a growing pause when it has failed.

        Raises:
            LinkError: It cannot be connected to, or the connection was lost.
            PeerError: It broke the rules of its protocol, or refuses homebot; the message gives the remedy.
        """

    @abstractmethod
    async def perform(self, command: Command) -> None:
        """Carry out a command, which fits the part it is for; return when the device has accepted it.

        Raises:
            LinkError: There is no connection.
            RefusedError: The device refuses.
        """


class DriverSession(Protocol):
    """One connection of a driver, from its start to its end."""

    async def run(self) -> None:
        """Perform the work of :meth:`Driver.run`."""

    async def perform(self, command: Command) -> None:
        """Perform a command as :meth:`Driver.perform` does."""


class SessionDriver(Driver):
    """A driver that creates a new session for each connection, so that no state is carried over."""

    def __init__(self, service: FoundService, settings: DriverSettings, host: DriverHost) -> None:
        super().__init__(service, settings, host)
        self._session: DriverSession | None = None

    @abstractmethod
    def open_session(self) -> DriverSession:
        """Return a new session that has not started; libraries of an extra are imported here."""

    async def run(self) -> None:
        """Keep a connection until cancelled."""
        self._session = self.open_session()
        try:
            await self._session.run()
        finally:
            self._session = None

    async def perform(self, command: Command) -> None:
        """Carry out *command* in the current session."""
        if self._session is None:
            raise LinkError(f"{self.service.name} is not connected")
        await self._session.perform(command)


async def first_answer(name: str, addresses: Sequence[str], ask: Callable[[str], Awaitable[Answer]]) -> Answer:
    """Ask one address after the other, and return the first answer.

    Args:
        name: The name of the device, for errors.
        addresses: Its addresses, best first.
        ask: Asks an address; a LinkError means that it does not answer.

    Raises:
        LinkError: None of them answers; the error of the last one.
    """
    failed = LinkError(f"{name} has no address")
    for address in addresses[:MAX_ASKED]:
        try:
            return await ask(address)
        except LinkError as exc:
            failed = exc
    raise failed
