"""The tool of ``homebot mcp`` for routines; annotations are not postponed: the SDK reads those."""

import json
from typing import Annotated, Final

from anyio import to_thread
from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult
from pydantic import Field

from homebot.cli.door_address import DoorAddress
from homebot.cli.mcp_server import ACTS, ApiClient, tool_answer
from homebot.errors import HomebotError
from homebot.features.routines.http import ProposalAnswer

_MOST_LINES: Final = 40


class _TriedProposal(ProposalAnswer):
    """The result of a proposal, and the newest lines of its trial."""

    trial: list[str]


def add_tools(server: MCPServer, api: ApiClient) -> None:
    """Add the tool to *server*."""

    async def propose_routine(
        text: Annotated[str, Field(max_length=20_000, description="TOML")],
        days: Annotated[float, Field(gt=0.0, le=366.0, description="of the trial")] = 7.0,
    ) -> Annotated[CallToolResult, _TriedProposal]:
        """Propose a rule to the owner, who enables it or not; returns what it would have done in the last days.

        TOML: `name="Hall"`, `when=["hall motion occupied", "22:00"]`, `if=["sun is down"]`,
        `do=["hall lamp on, 20 %", "wait 5m", "undo"]`.
        """
        answer = json.loads(await api.post("/api/routines", {"text": text}))
        trial = await to_thread.run_sync(_trial, api.address, text, days)
        return tool_answer(json.dumps({**answer, "trial": trial[-_MOST_LINES:]}, ensure_ascii=False))

    server.add_tool(propose_routine, annotations=ACTS)


def _trial(address: DoorAddress, text: str, days: float) -> list[str]:
    from homebot.features.routines.command_trial import text_trial  # noqa: PLC0415 - a replay needs the whole runtime

    try:
        return text_trial(address, text, days * 86_400.0)
    except HomebotError as exc:
        return [f"no trial: {exc}"]
