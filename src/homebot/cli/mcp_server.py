"""The client of ``homebot mcp``: the HTTP API of a running homebot, for the tools of agents.

Each request has its own connection, so that homebot may restart in between, and no thread: the SDK reads with threads,
and could neither hear nor end while all wait for slow devices.
"""

import json
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final
from urllib.parse import unquote

import httpx2
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from homebot.bridges.home_api.agent_server import AgentMistakeError, HouseApi, RosbridgeAddress
from homebot.cli.server_address import ServerAddress, client_context
from homebot.devices.names import HOME_HEADER
from homebot.rights import OfferedService

_MAX_WAIT_S: Final = 900.0
"""Seconds; homebot answers sooner, after the usual response time of the slowest device."""

_MAX_BYTES: Final = 4 * 1024 * 1024

_MAX_AT_ONCE: Final = 32
"""Requests that homebot is sent at the same time; it takes 64 clients."""


class ApiClient(HouseApi):
    """Client of the homebot at an address."""

    def __init__(self, address: ServerAddress) -> None:
        self._address = address
        self.server = RosbridgeAddress(address.host, address.port, address.token, address.has_tls)
        self._tls = client_context() if address.has_tls else None
        self._headers = {"Authorization": f"Bearer {address.token}"} if address.token else {}
        scheme = "https" if address.has_tls else "http"
        self._http = httpx2.AsyncClient(
            base_url=httpx2.URL(scheme=scheme, host=address.host, port=address.port),
            verify=self._tls or True,
            headers={"Content-Type": "application/json", **self._headers},
            timeout=_MAX_WAIT_S,
            limits=httpx2.Limits(max_connections=_MAX_AT_ONCE, max_keepalive_connections=0),
            trust_env=False,
        )

    async def ask(self, method: str, target: str, body: bytes = b"") -> tuple[int, str]:
        """See :meth:`HouseApi.ask`."""
        content = b""
        try:
            async with self._http.stream(method, target, content=body or None) as response:
                async for piece in response.aiter_bytes():
                    content = (content + piece)[:_MAX_BYTES]
        except httpx2.HTTPError as exc:
            raise self._no_answer(exc) from exc
        self._check_home(response.headers)
        return response.status_code, content.decode(errors="replace")

    @asynccontextmanager
    async def send_goal(
        self, action: OfferedService, goal: Mapping[str, object]
    ) -> AsyncIterator[Callable[[], Awaitable[Any]]]:
        """See :meth:`HouseApi.send_goal`."""
        frame = {"op": "send_action_goal", "id": "goal", "action": action.name, "args": goal, "feedback": True}
        where = f"{'ws' if self._tls is None else 'wss'}://{self._address.where}"
        try:
            async with connect(
                where, ssl=self._tls, additional_headers=self._headers, proxy=None, max_size=_MAX_BYTES
            ) as connection:
                self._check_home({} if connection.response is None else connection.response.headers)
                await connection.send(json.dumps({**frame, "action_type": action.ros_type}))

                async def received() -> Any:
                    return json.loads(await connection.recv())

                yield received
        except (OSError, WebSocketException) as exc:
            raise self._no_answer(exc) from exc

    def _check_home(self, headers: Mapping[str, str]) -> None:
        home = self._address.home
        served = unquote(headers.get(HOME_HEADER, ""))
        if home and served and served != home:
            problem = f"the homebot on {self._address.where} serves the home {served!r}, not {home!r}"
            raise AgentMistakeError("failed", problem)

    def _no_answer(self, cause: Exception) -> AgentMistakeError:
        problem = (
            f"no homebot answers on {self._address.host}:{self._address.port} ({cause}); start one with `homebot run`"
        )
        return AgentMistakeError("failed", problem)
