"""The tool of ``homebot mcp`` for routines; annotations are not postponed: the SDK reads those."""

import json
import os
import sys
from functools import cache
from typing import Annotated, Final

from anyio import NamedTemporaryFile, Semaphore, run_process
from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult
from pydantic import Field

from homebot.bridges.home_api.agent_server import ACTS, READS, HouseApi, Words, tool_answer
from homebot.bridges.home_api.shapes import Answer
from homebot.errors import HomebotError
from homebot.features.routines.http import ProposalAnswer, RoutineList
from homebot.features.routines.text import read_routines

_MAX_LINES: Final = 40


class _Trial(Answer):
    """The newest lines of a trial."""

    trial: list[str]


class _TriedProposal(_Trial, ProposalAnswer):
    """The result of a proposal, with its trial."""


def add_tools(server: MCPServer, api: HouseApi) -> None:
    """Add the tool to *server*."""

    async def propose_routine(
        text: Annotated[str, Field(max_length=20_000, description="TOML")],
        days: Annotated[float, Field(gt=0.0, le=366.0, description="of the trial")] = 7.0,
    ) -> Annotated[CallToolResult, _TriedProposal]:
        """Propose a rule, which only the owner enables; returns its trial on the last days.

        TOML: `name="Hall"`, `when=["hall motion occupied", "22:00"]`, `if=["sun is down"]`,
        `do=["hall lamp on, 20 %", "wait 5m", "undo"]`.
        """
        answer = json.loads(await api.post("/api/routines", {"text": text}))
        return tool_answer(json.dumps({**answer, "trial": await _trial(api, text, days)}, ensure_ascii=False))

    async def try_routine(
        text: Annotated[str, Field(max_length=20_000, description="TOML, as to propose_routine")],
        days: Annotated[float, Field(gt=0.0, le=366.0, description="how many")] = 7.0,
    ) -> Annotated[CallToolResult, _Trial]:
        """Try a rule on the last days; nothing is sent or proposed."""
        return tool_answer(_Trial(trial=await _trial(api, text, days)).model_dump_json())

    async def explain_routine(
        name: Annotated[Words, Field(description="empty for all")] = "",
    ) -> Annotated[CallToolResult, RoutineList]:
        """Return the text of a rule, whether it is enabled, its last runs, and why it cannot work."""
        return tool_answer(await api.read("/api/routines", name=name))

    server.add_tool(propose_routine, annotations=ACTS)
    server.add_tool(try_routine, annotations=READS)
    server.add_tool(explain_routine, annotations=READS)


async def _trial(api: HouseApi, text: str, days: float) -> list[str]:
    """Return the newest lines of a trial, by a process of its own: it computes for a while."""
    if api.is_of_house and not api.server.token:
        return ["no trial: it needs a token"]
    try:
        routines = "".join(routine.text for routine in read_routines(text, "the text"))
    except HomebotError as exc:
        return [f"no trial: {exc}"]
    place = api.server
    where = (
        f"{'wss' if place.has_tls else 'ws'}://{f'[{place.host}]' if ':' in place.host else place.host}:{place.port}"
    )
    env = os.environ | {"HOMEBOT_DOOR_TOKEN": place.token}
    async with _one_at_a_time(), NamedTemporaryFile(suffix=".toml") as file:
        await file.write(routines.encode())
        await file.flush()
        trial = ("-m", "homebot", "--door", where, "routine", "try", str(file.name), "--on", f"{days * 86_400:.0f}s")
        done = await run_process((sys.executable, *trial), env=env, check=False)
    lines = done.stdout.decode(errors="replace").splitlines()
    return lines[-_MAX_LINES:] if done.returncode == 0 else [f"no trial: {done.stderr.decode(errors='replace')[:500]}"]


@cache
def _one_at_a_time() -> Semaphore:
    return Semaphore(1)
