"""The driver for ``_shelly._tcp``, without the parts that need aiohttp: those load when the first device is found."""

from __future__ import annotations

from typing import ClassVar

from homebot.gateways.drivers.base import DriverSession, DriverSettings, SessionDriver
from homebot.gateways.drivers.shelly.settings import ShellyDriverSettings

__all__ = ["ShellyDriver"]


class ShellyDriver(SessionDriver):
    """One Shelly device of the second generation or later. Of the first generation, only model and firmware are listed.

    Source: Shelly Gen2+ API, Overview, Common Device Traits (mDNS).
    """

    service_types: ClassVar[frozenset[str]] = frozenset({"_shelly._tcp.local."})
    Settings: ClassVar[type[DriverSettings]] = ShellyDriverSettings
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)
    settings: ShellyDriverSettings

    def open_session(self) -> DriverSession:
        """Return a session; this loads aiohttp."""
        from homebot.gateways.drivers.shelly.session import ShellySession  # noqa: PLC0415 - an extra

        return ShellySession(self.service, self.settings, self.host)
