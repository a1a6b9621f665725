"""The tools of ``homebot mcp``: the HTTP API for agents. The only file that imports the MCP SDK and its HTTP client.

Each request has its own connection, so that homebot may restart in between, and no thread: the SDK reads with threads,
and could neither hear nor end while all wait for slow devices. Device names are untrusted, so they are
only in answers, never in descriptions. Annotations are not postponed here, because the SDK reads those of inner
functions.
"""

import json
from collections.abc import Mapping
from typing import Annotated, Final, TypeAlias
from urllib.parse import quote, unquote, urlencode

import httpx2
from mcp.server.elicitation import AcceptedElicitation, ElicitationResult
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.resolve import Elicit, Resolve
from mcp.types import ToolAnnotations
from pydantic import BaseModel, Field

from homebot.cli.door_address import DoorAddress
from homebot.devices.names import HOME_HEADER
from homebot.devices.outcomes import OUTCOMES
from homebot.support.printable import printable
from homebot.version import __version__

__all__ = ["ApiClient", "house_server"]

_GUIDE: Final = (
    "Devices of a house. Find a device first, then use its id. Every command returns its verified outcome: "
    f"{', '.join(OUTCOMES)}; if refused, with a reason. Do not retry a refusal."
)
_READS: Final = ToolAnnotations(read_only_hint=True, open_world_hint=False)
_ACTS: Final = ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=False)
_UNCONFIRMED: Final = {
    "outcome": "refused",
    "reason": "this device always asks, and no person confirmed the command",
}


_LONGEST: Final = 900.0
"""Seconds; homebot answers sooner, after the usual response time of the slowest device."""

_MOST: Final = 4 * 1024 * 1024

_MOST_AT_ONCE: Final = 32
"""Requests that homebot is sent at the same time; it takes 64 clients."""

Words: TypeAlias = Annotated[str, Field(max_length=500)]
"""An argument; as part of an address, homebot takes up to 8 KiB."""


class Sure(BaseModel):
    """Confirmation by a person."""

    confirm: bool = Field(description="whether to do it")


class _Unsent(Sure):
    """No person can be asked, or the device cannot be looked up to tell whether one must be."""

    confirm: bool = False
    problem: str


class ApiClient:
    """Client of the homebot at an address."""

    def __init__(self, address: DoorAddress) -> None:
        self._address = address
        host, port, token, _, _ = address
        self._http = httpx2.AsyncClient(
            base_url=httpx2.URL(scheme="http", host=host, port=port),
            headers={"Content-Type": "application/json", **({"Authorization": f"Bearer {token}"} if token else {})},
            timeout=_LONGEST,
            limits=httpx2.Limits(max_connections=_MOST_AT_ONCE, max_keepalive_connections=0),
            trust_env=False,
        )

    async def read(self, path: str, last: str = "", **query: object) -> str:
        """Return the answer of the route *path* and *last* as JSON; for a problem, its ``outcome`` and ``reason``."""
        asked = urlencode({name: value for name, value in query.items() if value != ""})
        return await self._ask("GET", f"{path}{quote(last, safe='')}?{asked}")

    async def post(self, path: str, body: Mapping[str, str]) -> str:
        """Return the answer to *body* as JSON, like :meth:`read`."""
        return await self._ask("POST", path, json.dumps(body).encode())

    async def _ask(self, method: str, target: str, body: bytes | None = None) -> str:
        host, port, _, _, home = self._address
        found = b""
        try:
            async with self._http.stream(method, target, content=body) as response:
                async for piece in response.aiter_bytes():
                    found = (found + piece)[:_MOST]
        except httpx2.HTTPError as exc:
            return _problem("failed", f"no homebot answers on {host}:{port} ({exc}); start one with `homebot run`")
        text, served = found.decode(errors="replace"), unquote(response.headers.get(HOME_HEADER, ""))
        if home and served and served != home:
            return _problem("failed", f"the homebot on {host}:{port} serves the home {served!r}, not {home!r}")
        return text.rstrip() if response.status_code == 200 else _refusal(text)


def house_server(api: ApiClient) -> MCPServer:
    """Return a server whose tools use *api*."""

    async def home() -> str:
        """Return the rooms of the house, with the number of devices by type."""
        return await api.read("/api/home")

    async def find_devices(query: Words = "", limit: int = 50) -> str:
        """Return the devices that fit a query such as `light in kitchen`, or all, with room and values."""
        return await api.read("/api/devices", q=query, limit=limit)

    async def why(device: Words, state: Words = "") -> str:
        """Return why a device is in its state or, given a state such as `on`, why it is not in that one."""
        return await api.read("/api/why/", device, state=state)

    async def history(device: Words, capability: Words = "", since: Words = "24h", points: int = 50) -> str:
        """Return past values of a device, or of one capability such as `temperature`, for the last `24h` or `7d`."""
        return await api.read("/api/history", device=device, capability=capability, since=since, points=points)

    async def details(device: Words) -> str:
        return await api.read("/api/devices/", device.partition("#")[0])

    async def sure(
        device: Words, do: Words, details: Annotated[str, Resolve(details)], context: Context
    ) -> Sure | Elicit[Sure]:
        return _question(details, device, do, context)

    async def command(
        device: Words,
        do: Words,
        details: Annotated[str, Resolve(details)],
        sure: Annotated[ElicitationResult[Sure], Resolve(sure)],
    ) -> str:
        """Command one device: `on`, `off`, `40 %`, `2700 K`, `heating_setpoint 21`, `open`, `lock`."""
        if isinstance(sure, AcceptedElicitation) and isinstance(sure.data, _Unsent):
            return sure.data.problem
        if not isinstance(sure, AcceptedElicitation) or not sure.data.confirm:
            return json.dumps(_UNCONFIRMED)
        return await api.post("/api/command", {"device": _target(json.loads(details), device), "do": do})

    server = MCPServer("homebot", instructions=_GUIDE, version=__version__, log_level="WARNING")
    for tool in (home, find_devices, why, history):
        server.add_tool(tool, annotations=_READS, structured_output=False)
    server.add_tool(command, annotations=_ACTS, structured_output=False)
    return server


def _target(details: Mapping[str, object], named: str) -> str:
    """Return the id of the device of *details*, with the *named* part: what a person agrees to, also after a rename."""
    _, mark, part = named.partition("#")
    return f"{details['id']}{mark}{part}"


def _question(details: str, named: str, do: str, context: Context) -> Sure | Elicit[Sure]:
    """Return the question to a person before *do* is sent to the device of *details*, or an answer without asking."""
    device, can = json.loads(details), context.client_capabilities
    if "id" not in device:
        return _Unsent(problem=details)
    if not (reason := device.get("always_asks")):
        return Sure(confirm=True)
    if can is None or can.elicitation is None:
        return _Unsent(problem=_problem("refused", "this device always asks, and this client cannot ask its person"))
    return Elicit(printable(f"{_target(device, named)}: {do}? It always asks: {reason}.", 2000), Sure)


def _refusal(text: str) -> str:
    try:
        found = json.loads(text)
        return _problem(found["outcome"], found["detail"])
    except (ValueError, KeyError, TypeError):
        return _problem("failed", f"the answer is not from a homebot: {text[:100]!r}")


def _problem(outcome: str, reason: str) -> str:
    return json.dumps({"outcome": outcome, "reason": reason}, ensure_ascii=False)
