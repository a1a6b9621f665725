"""The table ``[gateways.mdns.drivers.thing]``."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from homebot.gateways.drivers.base import DriverSettings
from homebot.gateways.things.http_credentials import HttpLoginSettings, read_logins
from homebot.units import Seconds

__all__ = ["ThingDriverSettings"]


class ThingDriverSettings(DriverSettings):
    """The settings of the driver for things.

    Attributes:
        credentials: The credentials of hosts that require some.
        poll_every: Seconds between two readings of values that a thing does not push.
    """

    credentials: tuple[HttpLoginSettings, ...] = ()
    poll_every: Annotated[Seconds, Field(ge=1.0)] = 30.0

    def check_secrets(self) -> None:
        """Read all credentials once.

        Raises:
            UsageError: A password cannot be read; names the key.
        """
        read_logins(self.credentials)
