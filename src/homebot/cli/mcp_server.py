"""The tools of ``homebot mcp``: the HTTP API, as an agent calls it. The one file that imports the MCP SDK.

Names of devices come from strangers, so they stand in answers alone and in no description. Annotations are not
postponed here: the SDK reads those of functions that know the client.
"""

import json
from typing import Annotated, Final

from mcp.server.elicitation import AcceptedElicitation, ElicitationResult
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.resolve import Elicit, Resolve
from mcp.types import ToolAnnotations
from pydantic import BaseModel, Field

from homebot.cli.api_client import ApiClient
from homebot.version import __version__

__all__ = ["house_server"]

_GUIDE: Final = (
    "Devices of a house. Find a device first, then use its id. Every command returns its proven outcome: confirmed, "
    "already_so, contradicted, reverted, no_answer, superseded, gone or refused with a reason. Do not retry a refusal."
)
_READS: Final = ToolAnnotations(read_only_hint=True, open_world_hint=False)
_ACTS: Final = ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=False)
_UNCONFIRMED: Final = {
    "outcome": "refused",
    "reason": "this device always asks, and no person confirmed the command",
}


class Sure(BaseModel):
    """The word of a person."""

    confirm: bool = Field(description="whether to do it")


class _Unknown(Sure):
    """The device cannot be looked up, so that it is not known whether it asks.

    Attributes:
        problem: The answer to the look-up.
    """

    confirm: bool = False
    problem: str


def house_server(api: ApiClient) -> MCPServer:
    """Return a server whose tools ask *api*."""

    async def home() -> str:
        """Return the rooms of the house, with the number of devices by type."""
        return await api.read("/api/home")

    async def find_devices(query: str = "", limit: int = 50) -> str:
        """Return the devices that fit a query such as `light in kitchen`, with room and values; all otherwise."""
        return await api.read("/api/devices", q=query, limit=limit)

    async def why(device: str, state: str = "") -> str:
        """Return why a device is as it is; with a state such as `on`, why it is not so."""
        return await api.read("/api/why/", device, state=state)

    async def history(device: str, capability: str = "", since: str = "24h", points: int = 50) -> str:
        """Return past values of a device, of one capability such as `temperature`, since `24h` or `7d` ago."""
        return await api.read("/api/history", device=device, capability=capability, since=since, points=points)

    async def sure(device: str, do: str, context: Context) -> Sure | Elicit[Sure]:
        return _question(await api.read("/api/devices/", device.partition("#")[0]), do, context)

    async def command(device: str, do: str, sure: Annotated[ElicitationResult[Sure], Resolve(sure)]) -> str:
        """Command one device: `on`, `off`, `40 %`, `2700 K`, `heating_setpoint 21`, `open`, `lock`."""
        if isinstance(sure, AcceptedElicitation) and isinstance(sure.data, _Unknown):
            return sure.data.problem
        if not isinstance(sure, AcceptedElicitation) or not sure.data.confirm:
            return json.dumps(_UNCONFIRMED)
        return await api.post("/api/command", {"device": device, "do": do})

    server = MCPServer("homebot", instructions=_GUIDE, version=__version__, log_level="WARNING")
    for tool in (home, find_devices, why, history):
        server.add_tool(tool, annotations=_READS, structured_output=False)
    server.add_tool(command, annotations=_ACTS, structured_output=False)
    return server


def _question(details: str, do: str, context: Context) -> Sure | Elicit[Sure]:
    """Return the question to a person before *do* reaches the device of *details*, or an answer where none is asked."""
    device, can = json.loads(details), context.client_capabilities
    if "id" not in device:
        return _Unknown(problem=details)
    if not (reason := device.get("always_asks")):
        return Sure(confirm=True)
    if can is None or can.elicitation is None:
        return Sure(confirm=False)
    return Elicit(f"{device['id']}: {do}? It always asks: {reason}.", Sure)
