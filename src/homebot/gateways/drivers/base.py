"""The contract of drivers; the plug-in group is ``homebot.drivers``.

DNS-SD announces a device and its address; a driver connects to it, describes its capabilities, reports its
states and sends it commands. There is one driver object for each found service, and it knows nothing of others.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Collection, Sequence
from typing import TYPE_CHECKING, ClassVar, Final, TypeVar

from pydantic import BaseModel, ConfigDict

from homebot.conventions.dns_sd import FoundService as FoundService
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, UnableError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.announced.device_runner import DriverHost
from homebot.plugins import check_extra

if TYPE_CHECKING:
    from homebot.gateways.http_client import HttpClient

Answer = TypeVar("Answer")

MAX_ASKED: Final = 4
"""Most addresses to try; a device has an IPv4 address and up to three of IPv6."""


class DriverSettings(BaseModel):
    """The table of a driver, ``[gateways.mdns.drivers.NAME]``; a driver's own model derives from it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def check_secrets(self) -> None:
        """Check the secrets that it names before anything starts.

        Raises:
            UsageError: One cannot be read; the message names the key.
        """


class Driver(ABC):
    """A driver for one service.

    A new one is created for each attempt to connect: after a failure, and when host, port or TXT record of the service
    have changed.

    Args:
        settings: The driver's table, checked; an instance of :attr:`Settings`.

    Attributes:
        service_types: Its DNS-SD service types: ``_shelly._tcp.local.``
        libraries: The top-level modules that it needs from homebot's extra ``mdns``.
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
        """Check the libraries and secrets of the driver before anything starts.

        Raises:
            UsageError: Something is missing; the message gives the remedy.
        """
        check_extra("it", "mdns", *cls.libraries)
        settings.check_secrets()

    def http_client(self, max_bytes: int, time_limit: float = 10.0) -> HttpClient:
        """Return a client for the service, at its own addresses alone, to be opened by ``async with``."""
        from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - an extra

        return HttpClient(guard=AddressGuard(self.service.addresses), max_bytes=max_bytes, time_limit=time_limit)

    @abstractmethod
    async def run(self) -> None:
        """Connect, describe the device, and report its states, until cancelled.

        The gateway runs it again with growing pauses after failures.

        Raises:
            LinkError: It cannot be reached, or the connection was lost.
            PeerError: It broke its protocol, or refuses homebot; the message gives the remedy.
        """

    @abstractmethod
    async def perform(self, command: Command) -> Collection[str] | None:
        """Carry out a command, already checked against its part; return when the device has accepted it.

        Returns:
            The capabilities of ``also`` that the same message set; None for none.

        Raises:
            LinkError: There is no connection.
            RefusedError: The device refuses.
        """

    async def refresh(self, key: str, part: str) -> None:
        """Ask the device for the values of a part, which it reports later.

        Raises:
            LinkError: There is no connection.
            UnableError: It cannot be asked.
        """
        del part
        raise UnableError(f"{key[:100]} answers no requests")


async def first_answer(name: str, addresses: Sequence[str], ask: Callable[[str], Awaitable[Answer]]) -> Answer:
    """Try one address after the other, and return the first answer.

    Args:
        addresses: Its addresses, best first.
        ask: Tries an address; a LinkError means that it does not answer.

    Raises:
        LinkError: None of them answers; it is the error of the last one.
    """
    failed = LinkError(f"{name} has no address")
    for address in addresses[:MAX_ASKED]:
        try:
            return await ask(address)
        except LinkError as exc:
            failed = exc
    raise failed
