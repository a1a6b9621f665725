"""Requests to one Hue bridge, at the rate that it allows, and its event stream.

Two requests run at a time: a bridge refuses more than three connections, and the events need one. Commands to lights
start at most ten times a second, those to scenes and groups once a second, in order. Requests for which the bridge was
too busy are repeated; a command without an answer is not.

Source: Philips Hue, CLIP API v2, "Getting started" (system performance), and its reference.
"""

from __future__ import annotations

import ssl
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager
from typing import TYPE_CHECKING, Final, TypeVar

import anyio
from pydantic import SecretStr

from homebot.clock import Clock
from homebot.conventions.payload import as_fields, clean_text, text_of
from homebot.errors import BusyError, RefusedError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.http_address import parse_url
from homebot.gateways.long_json import parse_long_json
from homebot.gateways.password_settings import HttpLogin
from homebot.integrations.hue.formats.resources import HueBody, at
from homebot.support.rate_limit import RateLimit

if TYPE_CHECKING:
    from homebot.gateways.http_client import HttpClient
    from homebot.gateways.http_streams import EventStream

AnswerT = TypeVar("AnswerT")

MAX_BYTES: Final = 8 * 1024 * 1024
"""Longest answer or event; all resources of 50 lights are about 200 kB."""

ANSWER_WITHIN: Final = 6.0

_TRIES: Final = 6
_PAUSE: Final = 0.25
_AT_ONCE: Final = 2
_GROUPS: Final = frozenset({"grouped_light", "scene", "smart_scene"})
_NOT_PRESSED: Final = 101
_MAY_NOT: Final = "may not have effect"
"""Part of the error text for a command that was sent nevertheless, such as to a lamp without power."""


def bridge_client(origin: str, tls: ssl.SSLContext, key: SecretStr | None = None) -> HttpClient:
    """Return a client for the bridge at an address, to be opened by ``async with``."""
    from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - an extra

    login = None if key is None else HttpLogin(origin, "header", "hue-application-key", key)
    guard = AddressGuard((parse_url(origin).host or "",))
    return HttpClient(guard=guard, login=login, tls=tls, time_limit=ANSWER_WITHIN, max_bytes=MAX_BYTES)


class BridgeLink:
    """Requests to a bridge that homebot is paired with, by an open *client* with the application key."""

    def __init__(self, client: HttpClient, origin: str, clock: Clock) -> None:
        self._client = client
        self._origin = origin
        self._clock = clock
        self._turns = anyio.Semaphore(_AT_ONCE)
        self._lights = RateLimit(10.0, 5.0)
        self._groups = RateLimit(1.0, 1.0)

    def events(self) -> AbstractAsyncContextManager[EventStream]:
        """Return the stream of events, for ``async with``."""
        return self._client.events(f"{self._origin}/eventstream/clip/v2")

    async def read(self, kind: str = "") -> object:
        """Return all resources of a type, by default of all types, in the bridge's order."""
        url = f"{self._origin}/clip/v2/resource{kind and f'/{kind}'}"
        answer = await self._ask(lambda: self._client.get(url))
        return as_fields(await parse_long_json(answer.body, MAX_BYTES)).get("data")

    async def change(self, what: str, kind: str, rid: str, body: HueBody) -> None:
        """Change a resource; return when the bridge has accepted it. Raises LinkError, or RefusedError about *what*."""
        url = f"{self._origin}/clip/v2/resource/{kind}/{rid}"
        limit = self._groups if kind in _GROUPS else self._lights
        errors = as_fields(await self._ask(lambda: self._client.send_json("PUT", url, body), limit)).get("errors")
        texts = [text_of(at(error, "description")) for error in errors] if isinstance(errors, list) else []
        problem = next((text for text in texts if _MAY_NOT not in text), "")
        if problem:
            raise RefusedError(what, problem)

    async def _ask(self, send: Callable[[], Awaitable[AnswerT]], limit: RateLimit | None = None) -> AnswerT:
        """Send a request in turn, repeating it while the bridge is too busy; return the answer."""
        attempt = 1
        while True:
            if limit is not None:
                await anyio.sleep(limit.charge(self._clock.monotonic()))
            try:
                async with self._turns:
                    return await send()
            except BusyError:
                if attempt == _TRIES:
                    raise
                await anyio.sleep(_PAUSE * attempt)
                attempt += 1


async def create_key(client: HttpClient, origin: str, name: str) -> SecretStr | None:
    """Return a new application key; None while the bridge's button has not been pressed."""
    answer = await client.send_json("POST", f"{origin}/api", {"devicetype": f"homebot#{clean_text(name, 19)}"})
    first = answer[0] if isinstance(answer, list) and answer else None
    key = at(first, "success", "username")
    if isinstance(key, str) and key:
        return SecretStr(key)
    if at(first, "error", "type") == _NOT_PRESSED:
        return None
    raise RefusedError("pairing", text_of(at(first, "error", "description")) or "the answer of the bridge is unknown")
