"""The tool of ``homebot mcp`` for routines; annotations are not postponed: the SDK reads those."""

import atexit
import json
import os
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Final

import anyio
from anyio import to_thread
from anyio.abc import Process
from mcp.server.mcpserver import MCPServer
from mcp.types import CallToolResult
from pydantic import Field

from homebot.bridges.home_api.agent_server import ACTS, READS, HouseApi, RosbridgeAddress, Words, tool_answer
from homebot.bridges.home_api.shapes import Answer
from homebot.errors import HomebotError
from homebot.features.routines.http import ProposalAnswer, RoutineList
from homebot.features.routines.text import read_routines

_MAX_LINES: Final = 40
_TEXT, _OUT, _ERRORS = "routines.toml", "out", "errors"
_ANSWERS_WITHIN: Final = 5.0
"""Seconds; clients of agents give up on slow tools."""


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
        return tool_answer(json.dumps({**answer, "trial": await _TRIALS.lines(api, text, days)}, ensure_ascii=False))

    async def try_routine(
        text: Annotated[str, Field(max_length=20_000, description="TOML, as to propose_routine")],
        days: Annotated[float, Field(gt=0.0, le=366.0, description="how many")] = 7.0,
    ) -> Annotated[CallToolResult, _Trial]:
        """Try a rule on the last days; nothing is sent or proposed. If it goes on, ask the same again later."""
        return tool_answer(_Trial(trial=await _TRIALS.lines(api, text, days)).model_dump_json())

    async def explain_routine(
        name: Annotated[Words, Field(description="empty for all")] = "",
    ) -> Annotated[CallToolResult, RoutineList]:
        """Return the text of a rule, whether it is enabled, its last runs, and why it cannot work."""
        return tool_answer(await api.read("/api/routines", name=name))

    server.add_tool(propose_routine, annotations=ACTS)
    server.add_tool(try_routine, annotations=READS)
    server.add_tool(explain_routine, annotations=READS)


@dataclass(frozen=True, slots=True)
class _RunningTrial:
    """A trial in a process of its own: it computes for a while.

    Attributes:
        asked: The rosbridge server with its token, the routines and the days.
        folder: Its output.
    """

    asked: tuple[RosbridgeAddress, str, float]
    process: Process
    folder: TemporaryDirectory[str]


class Trials:
    """The trials of all agents, one at a time. One that goes on when its time to answer is over keeps its lines.

    Args:
        answers_within: Seconds after which :meth:`lines` answers in any case.
    """

    def __init__(self, answers_within: float) -> None:
        self._answers_within = answers_within
        self._running: _RunningTrial | None = None
        self._turn = anyio.Semaphore(1)

    async def lines(self, api: HouseApi, text: str, days: float) -> list[str]:
        """Return the newest lines of a trial, or that one goes on."""
        if api.is_of_house and not api.server.token:
            return ["no trial: it needs a token"]
        try:
            routines = "".join(routine.text for routine in read_routines(text, "the text"))
        except HomebotError as exc:
            return [f"no trial: {exc}"]
        asked = api.server, routines, days
        with anyio.move_on_after(self._answers_within):
            async with self._turn:
                if self._running is not None and self._running.asked != asked:
                    await self._end(self._running)
                return await self._end(self._running or await self._start(asked))
        return ["a trial goes on: ask the same again later"]

    def close(self) -> None:
        """End the trial that goes on, if any; idempotent."""
        if self._running is not None:
            with suppress(ProcessLookupError):  # it has just ended
                self._running.process.kill()

    async def _start(self, asked: tuple[RosbridgeAddress, str, float]) -> _RunningTrial:
        place, routines, days = asked
        host = f"[{place.host}]" if ":" in place.host else place.host
        where = f"{'wss' if place.has_tls else 'ws'}://{host}:{place.port}"
        env = os.environ | {"HOMEBOT_DOOR_TOKEN": place.token}
        with anyio.CancelScope(shield=True):  # a process that was begun is kept
            folder = await to_thread.run_sync(_folder, routines)
            file, out, errors = (f"{folder.name}/{name}" for name in (_TEXT, _OUT, _ERRORS))
            trial = ("-m", "homebot", "--door", where, "routine", "try", file, "--on", f"{days * 86_400:.0f}s")
            async with await anyio.open_file(out, "wb") as lines, await anyio.open_file(errors, "wb") as problems:
                process = await anyio.open_process(
                    (sys.executable, *trial), env=env, stdout=lines.wrapped, stderr=problems.wrapped
                )
            self._running = running = _RunningTrial(asked, process, folder)
        return running

    async def _end(self, running: _RunningTrial) -> list[str]:
        """Wait for the end of the running trial, and return its lines."""
        code = await running.process.wait()
        self._running = None
        out, errors = await to_thread.run_sync(_read, running.folder)
        return out.splitlines()[-_MAX_LINES:] if code == 0 else [f"no trial: {errors[:500]}"]


def _folder(routines: str) -> TemporaryDirectory[str]:
    folder = TemporaryDirectory()
    Path(folder.name, _TEXT).write_text(routines, "utf-8")
    return folder


def _read(folder: TemporaryDirectory[str]) -> tuple[str, str]:
    """Remove *folder*, and return the output and the errors, which name no file of this computer."""
    with folder as path:
        out, errors = (Path(path, name).read_text("utf-8", errors="replace") for name in (_OUT, _ERRORS))
    return out, errors.replace(f"{path}/{_TEXT}", "the text")


_TRIALS: Final = Trials(_ANSWERS_WITHIN)
atexit.register(_TRIALS.close)
