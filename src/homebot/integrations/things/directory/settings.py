"""The table ``[gateways.NAME]`` of a gateway to a directory of things."""

from typing import Annotated
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field

from homebot.gateways.base import GatewaySettings
from homebot.gateways.password_settings import HttpLoginSettings
from homebot.units import Seconds


def _check_url(url: str) -> str:
    problem = ValueError("is not an address such as http://192.168.1.2:8081")
    try:
        parts = urlsplit(url)
        has_port = parts.port != 0
    except ValueError:
        raise problem from None
    if parts.scheme not in {"http", "https"} or not parts.hostname or not has_port:
        raise problem
    if parts.username is not None or parts.password is not None or parts.query:
        raise ValueError("contains a user, a password or a query; give credentials instead")
    return url.rstrip("/")


class ThingDirectorySettings(GatewaySettings):
    """The settings of a gateway to a directory of things.

    Attributes:
        url: The address below which the directory has ``/things`` and ``/events``.
        credentials: The credentials of the directory, which names its *scheme*, and of things.
        list_every: Seconds between readings of the directory, if it does not report changes.
        poll_every: Seconds between readings of values that a thing does not push.
        max_devices: Most known things.
    """

    url: Annotated[str, AfterValidator(_check_url)]
    credentials: tuple[HttpLoginSettings, ...] = ()
    list_every: Annotated[Seconds, Field(ge=1.0)] = 60.0
    poll_every: Annotated[Seconds, Field(ge=1.0)] = 30.0
    max_devices: Annotated[int, Field(ge=1, le=10_000)] = 1000
