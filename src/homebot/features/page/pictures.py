"""Still pictures for the page: of gateways that have them, and at addresses that the owner names."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Annotated, Final, NamedTuple, final

import anyio
import anyio.to_thread
from pydantic import BaseModel, Field, SecretStr, field_validator

from homebot.config import parse_settings
from homebot.devices.names import FIND_DEVICES, GatewayNames
from homebot.devices.picture_messages import (
    MAX_PICTURE_BYTES,
    GetPicture,
    PictureRequest,
    PictureResponse,
    picture_of,
)
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.errors import HomebotError, ServiceUnavailableError
from homebot.features.page import GET_PICTURE, LIST_PICTURES
from homebot.features.page.messages import ListPictures, PictureNamesResponse
from homebot.gateways.password_settings import HttpLogin, PasswordSettings
from homebot.plugins import check_extra
from homebot.support.folding import fold

if TYPE_CHECKING:
    from homebot.config import Config
    from homebot.devices.device import Device
    from homebot.features.page.messages import PictureNamesRequest
    from homebot.gateways.http_client import HttpClient
    from homebot.graph import Node

_FRESH: Final = 1.0
"""Seconds for which a picture is given again, to however many screens."""

_MAX_KEPT: Final = 16
_MAX_AT_ONCE: Final = 4
_TIME_LIMIT: Final = 10.0
_KINDS: Final = frozenset({"camera", "video_player", "speaker"})


class PictureSettings(PasswordSettings):
    """The table ``[pictures.NAME]``; NAME is the id or a name of a device, or names a camera that is no device.

    Attributes:
        url: The address of a still picture, ``http`` or ``https``, a secret as many have a password. Redirects to
            another host are not followed.
        user: The user of the password.
    """

    url: Annotated[SecretStr, Field(max_length=2000)]
    user: str = ""

    @field_validator("url")
    @classmethod
    def _is_address(cls, url: SecretStr) -> SecretStr:
        scheme, _, rest = url.get_secret_value().partition("://")
        if scheme not in {"http", "https"} or not rest or "@" in rest.partition("/")[0]:
            raise ValueError(
                "the address of a picture is written like http://192.168.1.20/snapshot.jpg, without a user"
            )
        return url


class _PictureTables(BaseModel):
    pictures: dict[str, PictureSettings]


def read_pictures(config: Config) -> Mapping[str, PictureSettings]:
    """Return the tables ``[pictures.NAME]`` by their names.

    Raises:
        ConfigError: One is wrong.
    """
    table = {"pictures": config.features["pictures"]}
    return parse_settings(_PictureTables, table, config.source, "", config.folder).pictures


class _Kept(NamedTuple):
    at: float
    answer: PictureResponse


@final
class Pictures:
    """Pictures of devices, each fetched once however many screens look at it."""

    def __init__(self, node: Node, tables: Mapping[str, PictureSettings]) -> None:
        self._node = node
        self._tables = {fold(name): (name, table) for name, table in tables.items()}
        self._kept: dict[str, _Kept] = {}
        self._fetching: dict[str, anyio.Event] = {}
        self._limiter = anyio.CapacityLimiter(_MAX_AT_ONCE)
        self._devices = node.create_client(FindDevices, FIND_DEVICES)

    def offer(self) -> None:
        """Offer the services."""
        self._node.create_service(GetPicture, GET_PICTURE.name, self.get, concurrent=True)
        self._node.create_service(ListPictures, LIST_PICTURES.name, self.names)

    def names(self, _: PictureNamesRequest) -> PictureNamesResponse:
        """Return the names of the tables."""
        return PictureNamesResponse(success=True, message="", names=tuple(name for name, _ in self._tables.values()))

    async def get(self, request: PictureRequest) -> PictureResponse:
        """Return the newest picture of a device, or why there is none."""
        key, clock = request.device, self._node.graph.clock
        while (fetching := self._fetching.get(key)) is not None:
            await fetching.wait()
        kept = self._kept.get(key)
        if kept is not None and clock.monotonic() - kept.at < _FRESH:
            return kept.answer
        self._fetching[key] = anyio.Event()
        try:
            async with self._limiter:
                answer = await self._fetch(key)
        except HomebotError as exc:
            answer = PictureResponse(success=False, message=str(exc))
        finally:
            self._fetching.pop(key).set()
        self._kept.pop(key, None)
        self._kept[key] = _Kept(clock.monotonic(), answer)
        while len(self._kept) > _MAX_KEPT:
            del self._kept[next(iter(self._kept))]
        return answer

    async def _fetch(self, key: str) -> PictureResponse:
        found = await self._devices.call(FindDevicesRequest(ids=(key,)))
        device = found.devices[0] if found.devices else None
        names = (key,) if device is None else (device.id, *device.names)
        row = next((self._tables[name] for name in map(fold, names) if name in self._tables), None)
        if row is not None:
            return await self._download(*row)
        if device is None:
            return PictureResponse(success=False, message=f"there is no device or picture {key[:100]!r}")
        return await self._ask(device)

    async def _download(self, name: str, table: PictureSettings) -> PictureResponse:
        async with _client(name, table) as client:
            return picture_of(name, (await client.get(table.url.get_secret_value(), accept="image/*")).body)

    async def _ask(self, device: Device) -> PictureResponse:
        """Ask the gateways of a device, a camera before a cover."""
        answer = PictureResponse(success=False, message=f"{device.name} has no picture")
        parts = [one for one in device.parts if one.part.service_type in _KINDS]
        for part in sorted(parts, key=lambda one: one.part.service_type != "camera"):
            for route in part.routes:
                client = self._node.create_client(GetPicture, GatewayNames(route.gateway).picture)
                try:
                    answer = await client.call(PictureRequest(device=route.key, part=route.part), _TIME_LIMIT)
                except ServiceUnavailableError:  # its gateway has no pictures
                    continue
                finally:
                    client.close()
                if answer.success:
                    return answer
        return answer


@asynccontextmanager
async def _client(name: str, table: PictureSettings) -> AsyncIterator[HttpClient]:
    check_extra("a picture at an address", "mdns", "aiohttp")
    from homebot.gateways.http_address import parse_url  # noqa: PLC0415 - an extra
    from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - likewise

    password = await anyio.to_thread.run_sync(table.read_password, f"pictures.{name}.")
    origin = str(parse_url(table.url.get_secret_value()).origin())
    login = None if password is None else HttpLogin(origin, "basic", table.user, SecretStr(password.get_secret_value()))
    async with HttpClient(guard=None, login=login, time_limit=_TIME_LIMIT, max_bytes=MAX_PICTURE_BYTES) as client:
        yield client
