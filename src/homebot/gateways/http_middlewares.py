"""Middlewares of aiohttp: credentials for one server, and redirects that stay at the host that was asked.

A device that was found may be an attacker's. It must not make this computer send requests elsewhere, least of all to
services for this computer alone.

Source: RFC 7617 (Basic authentication), RFC 6750 (Bearer).
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

import aiohttp
from yarl import URL

from homebot.errors import RefusedError
from homebot.gateways.password_settings import HttpLogin

if TYPE_CHECKING:
    from aiohttp.client_middlewares import ClientHandlerType, ClientMiddlewareType

_asked: ContextVar[URL | None] = ContextVar("homebot_http_asked", default=None)


def authentication(login: HttpLogin) -> ClientMiddlewareType:
    """Return the middleware that adds the credentials to requests to their server, and to no others."""
    secret = login.password.get_secret_value()
    origin = URL(login.origin).origin()
    name, value = _header_of(login, secret)

    async def authenticate(request: aiohttp.ClientRequest, handler: ClientHandlerType) -> aiohttp.ClientResponse:
        if _as_http(request.url).origin() == origin:
            request.headers[name] = value
        return await handler(request)

    return authenticate


def _as_http(url: URL) -> URL:
    return url.with_scheme({"ws": "http", "wss": "https"}.get(url.scheme, url.scheme))


def _header_of(login: HttpLogin, secret: str) -> tuple[str, str]:
    match login.scheme:
        case "basic":
            return "Authorization", f"Basic {b64encode(f'{login.user}:{secret}'.encode()).decode()}"
        case "bearer":
            return "Authorization", f"Bearer {secret}"
        case _:
            return login.user, secret


@contextmanager
def staying_at(where: URL) -> Iterator[None]:
    """Have the requests that this task sends inside the block stay at the host of *where*."""
    token = _asked.set(where)
    try:
        yield
    finally:
        _asked.reset(token)


async def follow_own_redirects(request: aiohttp.ClientRequest, handler: ClientHandlerType) -> aiohttp.ClientResponse:
    """Send a request, as a middleware of aiohttp, which sees each redirect as one more.

    Raises:
        RefusedError: It goes to another host than the block says.
    """
    asked = _asked.get()
    if asked is not None and request.url.host != asked.host:
        raise RefusedError(f"{request.method} {asked.origin()}", "it redirects to another host, which is not followed")
    return await handler(request)
