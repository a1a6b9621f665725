"""The tool for goals of ``homebot mcp``. Annotations are not postponed: the SDK reads those of inner functions."""

from typing import Annotated

from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult
from pydantic import Field

from homebot.bridges.home_api.agent_server import ACTS, HouseApi, tool_answer
from homebot.features.goals.http import GoalAnswer


def add_tools(server: MCPServer, api: HouseApi) -> None:
    """Add the tool to *server*."""

    async def achieve(
        goal: Annotated[str, Field(max_length=1000, description="states joined by `and`")],
        dry_run: Annotated[bool, Field(description="only plan")] = False,  # noqa: FBT002 - JSON
    ) -> Annotated[CallToolResult, GoalAnswer]:
        """Plan how to reach a goal such as `kitchen lit and rosie in kitchen`, and do it; returns each step."""
        return tool_answer(await api.post("/api/goal", {"goal": goal, "dry_run": dry_run}))

    server.add_tool(achieve, annotations=ACTS)
