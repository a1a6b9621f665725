"""The tools for scenes of ``homebot mcp``. Annotations are not postponed: the SDK reads those of inner functions."""

from typing import Annotated

from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult
from pydantic import Field

from homebot.bridges.home_api.agent_server import ACTS, READS, HouseApi, Words, tool_answer
from homebot.bridges.home_api.shapes import OutcomeAnswer
from homebot.devices.command_messages import MAX_TRANSITION_S
from homebot.features.scenes.http import SceneList


def add_tools(server: MCPServer, api: HouseApi) -> None:
    """Add the tools to *server*."""

    async def scenes() -> Annotated[CallToolResult, SceneList]:
        """Return the scenes: a name, and values for several parts of the house."""
        return tool_answer(await api.read("/api/scenes"))

    async def apply_scene(
        scene: Annotated[Words, Field(description="name or id")],
        transition: Annotated[float, Field(ge=0.0, le=MAX_TRANSITION_S, description="seconds")] = 0.0,
        undo: Annotated[bool, Field(description="bring back the values before")] = False,  # noqa: FBT002 - JSON
    ) -> Annotated[CallToolResult, OutcomeAnswer]:
        """Apply a scene, or undo it: bring back the values before, where nothing else has changed them since."""
        return tool_answer(await api.post("/api/scene", {"scene": scene, "transition": transition, "undo": undo}))

    server.add_tool(scenes, annotations=READS)
    server.add_tool(apply_scene, annotations=ACTS)
