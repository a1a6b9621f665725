"""The driver for things on the network, without the parts that need aiohttp: those load with the first thing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError
from homebot.gateways.drivers.base import Driver, DriverSettings
from homebot.gateways.password_settings import HttpLoginSettings, read_logins
from homebot.units import Seconds

if TYPE_CHECKING:
    from homebot.integrations.things.driver.session import ThingSession


class ThingDriverSettings(DriverSettings):
    """The settings of the driver for things.

    Attributes:
        credentials: The credentials of hosts that require some.
        poll_every: Seconds between two readings of values that a thing does not push.
    """

    credentials: tuple[HttpLoginSettings, ...] = ()
    poll_every: Annotated[Seconds, Field(ge=1.0)] = 30.0

    def check_secrets(self) -> None:
        """Read all credentials once."""
        read_logins(self.credentials)


class ThingDriver(Driver):
    """One thing that serves its description; of a directory of things, only the address is listed.

    Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, section 6.3 (DNS-Based Service
    Discovery).
    """

    service_types: ClassVar[frozenset[str]] = frozenset({"_wot._tcp.local."})
    Settings: ClassVar[type[DriverSettings]] = ThingDriverSettings
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)
    settings: ThingDriverSettings

    _session: ThingSession | None = None

    async def run(self) -> None:
        """Read the description and use the thing until cancelled."""
        from homebot.integrations.things.driver.session import ThingSession  # noqa: PLC0415 - an extra

        logins = read_logins(self.settings.credentials)
        self._session = ThingSession(self.service, self.host, logins, self.settings.poll_every)
        await self._session.run()

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        if self._session is None:
            raise LinkError(f"{self.service.name} is not connected")
        await self._session.perform(command)
