"""The driver for ``_wled._tcp``, without the parts that need aiohttp: those load when the first device is found."""

from __future__ import annotations

from typing import ClassVar

from homebot.gateways.drivers.base import DriverSession, SessionDriver

__all__ = ["WledDriver"]


class WledDriver(SessionDriver):
    """One light strip, or several on one controller.

    Source: WLED 0.13 to 0.15, https://kno.wled.ge/interfaces/json-api and /websocket.
    """

    service_types: ClassVar[frozenset[str]] = frozenset({"_wled._tcp.local."})
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)

    def open_session(self) -> DriverSession:
        """Return a session; this loads aiohttp."""
        from homebot.gateways.drivers.wled.session import WledSession  # noqa: PLC0415 - an extra

        return WledSession(self.service, self.host)
