"""The tool of ``homebot mcp`` for the history; annotations are not postponed: the SDK reads those."""

from typing import Annotated

from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult
from pydantic import Field

from homebot.bridges.home_api.agent_server import READS, Device, HouseApi, Words, tool_answer
from homebot.features.history.http import MAX_POINTS, HistoryAnswer


def add_tools(server: MCPServer, api: HouseApi) -> None:
    """Add the tool to *server*."""

    async def history(
        device: Device,
        capability: Annotated[Words, Field(description="empty for all")] = "",
        since: Annotated[str, Field(max_length=40, description="how far back")] = "24h",
        points: Annotated[int, Field(ge=1, le=MAX_POINTS, description="most values of each")] = 50,
    ) -> Annotated[CallToolResult, HistoryAnswer]:
        """Return past values of a device, or of one capability such as `temperature`, for the last `24h` or `7d`."""
        answer = await api.read("/api/history", device=device, capability=capability, since=since, points=points)
        return tool_answer(answer)

    server.add_tool(history, annotations=READS)
