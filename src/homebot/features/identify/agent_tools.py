"""The tool of ``homebot mcp`` that identifies; annotations are not postponed: the SDK reads those."""

from operator import itemgetter
from typing import Annotated, Any

from mcp.server.mcpserver import Context, MCPServer
from mcp.types import CallToolResult
from pydantic import BaseModel, Field

from homebot.bridges.home_api.agent_server import ACTS, HouseApi, Words, tool_answer
from homebot.features.identify import IDENTIFY_DEVICE


class CandidateLine(BaseModel):
    """A candidate, and by how much it changes the sensor's value; the problem if it takes part no more."""

    device: str
    part: str
    probability: float
    effect: float | None
    deviation: float | None
    problem: str


class IdentifyAnswer(BaseModel):
    """The part in view, empty for none of the candidates and if it is not sure."""

    success: bool
    message: str
    device: str
    part: str
    probability: float
    left_out: list[dict[str, str]]
    candidates: list[CandidateLine]


def add_tools(server: MCPServer, api: HouseApi) -> None:
    """Add the tool to *server*."""

    async def identify(
        devices: Annotated[Words, Field(description="a query")],
        sensor: Annotated[Words, Field(description="its id or name, or a topic of a robot")],
        context: Context,
        at_night: Annotated[bool, Field(description="also while people sleep")] = False,  # noqa: FBT002 - JSON
    ) -> Annotated[CallToolResult, IdentifyAnswer]:
        """Find which `light in hall` a sensor sees: they blink."""
        goal = {"candidates": devices, "topic": sensor, "at_night": at_night}

        async def report(feedback: Any) -> None:
            best = max(feedback["candidates"], key=itemgetter("probability"))
            likely, none = best["probability"], feedback["none"]
            await context.report_progress(feedback["look"]["at"], None, f"{best['name']} {likely:.0%}, none {none:.0%}")

        result = await api.perform_goal(IDENTIFY_DEVICE, goal, report)
        return tool_answer(IdentifyAnswer.model_validate(result).model_dump_json())

    server.add_tool(identify, annotations=ACTS)
