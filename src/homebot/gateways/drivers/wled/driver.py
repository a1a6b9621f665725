"""The driver for ``_wled._tcp``, without the parts that need aiohttp: those load when the first device is found."""

from __future__ import annotations

from typing import ClassVar

from homebot.extras import check_extra
from homebot.gateways.drivers.base import DriverSession, DriverSettings, SessionDriver

__all__ = ["WledDriver"]


class WledDriver(SessionDriver):
    """One light strip, or several on one controller.

    Source: WLED 0.13 to 0.15, https://kno.wled.ge/interfaces/json-api and /websocket.
    """

    service_types: ClassVar[frozenset[str]] = frozenset({"_wled._tcp.local."})

    @classmethod
    def check(cls, settings: DriverSettings) -> None:
        """Check that aiohttp is installed."""
        del settings
        check_extra('the driver "wled"', "mdns", "aiohttp")

    def open_session(self) -> DriverSession:
        """Return a session; this loads aiohttp."""
        from homebot.gateways.drivers.wled.session import WledSession  # noqa: PLC0415 - an extra

        return WledSession(self.service, self.host)
