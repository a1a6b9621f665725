"""The tool of ``homebot mcp`` for habits; annotations are not postponed: the SDK reads those."""

from typing import Annotated

from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult

from homebot.bridges.home_api.agent_server import READS, HouseApi, tool_answer
from homebot.features.habits.http import HabitList


def add_tools(server: MCPServer, api: HouseApi) -> None:
    """Add the tool to *server*."""

    async def habits() -> Annotated[CallToolResult, HabitList]:
        """Return what people did again and again in the last 28 days, as routines with proof; the owner accepts."""
        return tool_answer(await api.read("/api/habits"))

    server.add_tool(habits, annotations=READS)
