"""Redirects that stay at the host that was asked; a helper of :mod:`homebot.gateways.http_client`.

A device that was found may be an attacker's. It must not make this computer send requests elsewhere, least of all to
services for this computer alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

import aiohttp
from yarl import URL

from homebot.errors import RefusedError

if TYPE_CHECKING:
    from aiohttp.client_middlewares import ClientHandlerType

__all__ = ["follow_own_redirects", "staying_at"]

_asked: ContextVar[URL | None] = ContextVar("homebot_http_asked", default=None)


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
