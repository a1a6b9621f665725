"""The driver for things on the network, without the parts that need aiohttp: those load with the first thing."""

from __future__ import annotations

from typing import ClassVar, Final

from homebot.gateways.drivers.base import DriverSession, DriverSettings, SessionDriver
from homebot.gateways.drivers.thing.settings import ThingDriverSettings

__all__ = ["WEB_THING", "HttpThingDriver", "ThingDriver"]

WEB_THING: Final = "_webthing._tcp.local."


class ThingDriver(SessionDriver):
    """One thing that serves its description; of a directory of things, only the address is listed.

    Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, section 6.3 (DNS-Based Service
    Discovery); of ``_webthing._tcp``, Web Thing API, section 2.

    Attributes:
        must_describe: Whether a host without a description is an error.
    """

    service_types: ClassVar[frozenset[str]] = frozenset({"_wot._tcp.local.", WEB_THING})
    Settings: ClassVar[type[DriverSettings]] = ThingDriverSettings
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)
    must_describe: ClassVar[bool] = True
    settings: ThingDriverSettings

    def open_session(self) -> DriverSession:
        """Return a session; this loads aiohttp."""
        from homebot.gateways.drivers.thing.session import ThingSession  # noqa: PLC0415 - an extra

        return ThingSession(self.service, self.settings, self.host, must_describe=self.must_describe)


class HttpThingDriver(ThingDriver):
    """A web server that may be a thing: its description is looked for at ``/.well-known/wot``.

    It is used only if the configuration names it, because it sends a request to every web server on the network.

    Source: as above, section 6.2 (Well-Known URIs).
    """

    service_types: ClassVar[frozenset[str]] = frozenset({"_http._tcp.local."})
    must_describe: ClassVar[bool] = False
