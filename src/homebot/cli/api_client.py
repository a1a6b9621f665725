"""The command line's end of the HTTP API: one connection for each request, so that homebot may restart in between."""

from __future__ import annotations

import json
from collections.abc import Mapping
from http.client import HTTPConnection, HTTPException
from typing import Final
from urllib.parse import quote, unquote, urlencode

from anyio import to_thread

from homebot.cli.door_address import DoorAddress
from homebot.devices.names import HOME_HEADER

__all__ = ["ApiClient"]

_LONGEST: Final = 900.0
"""Seconds; homebot answers sooner, when the time is over in which the slowest device usually does."""

_MOST: Final = 4 * 1024 * 1024


class ApiClient:
    """Asks the homebot at an address.

    Args:
        address: Where it is, and the token to show.
    """

    def __init__(self, address: DoorAddress) -> None:
        self._address = address

    async def read(self, path: str, last: str = "", **query: object) -> str:
        """Return the answer of the route *path* and *last*, as JSON; of a problem its ``outcome`` and ``reason``."""
        asked = urlencode({name: value for name, value in query.items() if value != ""})
        return await to_thread.run_sync(self._ask, "GET", f"{path}{quote(last)}?{asked}", None)

    async def post(self, path: str, body: Mapping[str, str]) -> str:
        """Return the answer to *body*, likewise."""
        return await to_thread.run_sync(self._ask, "POST", path, json.dumps(body).encode())

    def _ask(self, method: str, target: str, body: bytes | None) -> str:
        host, port, token, _, home = self._address
        connection = HTTPConnection(host, port, timeout=_LONGEST)
        headers = {"Content-Type": "application/json", **({"Authorization": f"Bearer {token}"} if token else {})}
        try:
            connection.request(method, target, body, headers)
            response = connection.getresponse()
            text = response.read(_MOST).decode(errors="replace")
        except (OSError, HTTPException) as exc:
            return _problem("failed", f"no homebot answers on {host}:{port} ({exc}); start one with `homebot run`")
        finally:
            connection.close()
        served = unquote(response.headers.get(HOME_HEADER, ""))
        if home and served and served != home:
            return _problem("failed", f"the homebot on {host}:{port} is of the home {served!r}, not {home!r}")
        return text.rstrip() if response.status == 200 else _refusal(text)


def _refusal(text: str) -> str:
    try:
        found = json.loads(text)
        return _problem(found["outcome"], found["detail"])
    except (ValueError, KeyError, TypeError):
        return _problem("failed", f"the answer is not that of a homebot: {text[:100]!r}")


def _problem(outcome: str, reason: str) -> str:
    return json.dumps({"outcome": outcome, "reason": reason}, ensure_ascii=False)
