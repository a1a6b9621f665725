"""Trials of routines by an agent, which asks again while one goes on."""

import json
from typing import Any

import anyio
from tests.patience import PATIENCE

GOES_ON = "a trial goes on: ask the same again later"


async def trial_of(session: Any, text: str) -> list[str]:
    """Return the lines of the trial of *text*; each question waits for them for some seconds."""
    lines = [GOES_ON]
    with anyio.fail_after(PATIENCE):
        while lines == [GOES_ON]:
            answer = await session.call_tool("try_routine", {"text": text})
            lines = json.loads(answer.content[0].text)["trial"]
    return lines
