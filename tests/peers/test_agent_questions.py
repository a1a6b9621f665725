"""What people ask an agent: the calls of docs/agents.md, played by the client of the SDK over HTTP and stdio."""

import ast
import json
import re
import sys
import tomllib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from tests.bridges.home_api.api import TOKENS, Api, bearer
from tests.guide import guide
from tests.patience import PATIENCE
from tests.peers.agent_trials import GOES_ON, trial_of

from homebot.config import parse_config
from homebot.house import World
from homebot.house.description import parse_world
from homebot.runtime import Runtime

ROWS = re.findall(r"^\| ([^|]+[?!]) \| `(.*)` \|$", guide("agents"), re.MULTILINE)
CALLS = {question: ast.parse(call, mode="eval").body for question, call in ROWS}
HOUSE = Path(__file__).parents[2] / "examples" / "houses" / "family.toml"

ANSWERS = {
    "Which kitchen lights are on?": '"note":"none now; in another state there would be kitchen lamp"',
    "Is the front door locked?": '"lock":"locked"',
    "Open windows?": '"devices":[',
    "How warm is the nursery?": '"local_temperature":',
    "Who is home?": '{"id":"anna","type":"x_person","name":"Anna","at_home":true}',
    "Where is the robot?": '"type":"x_robot"',
    "Any battery low?": '"devices":[]',
    "Kitchen lights at 40 %!": '{"id":"all lights in kitchen","outcome":"confirmed"',
    "Living room off!": '"living_lamp":"',
    "Bedroom at 30 %, warm white!": '"outcome":"confirmed"',
    "Nursery warmer!": '"outcome":"confirmed"',
    "Living room at 22 degrees!": "set living_heat to 22 °C: confirmed",
    "Unlock the front door!": "refused (approval): front_lock is unsafe (it is a door lock)",
    "Why is the kitchen lamp on?": "the client manager asked for level 40 %",
    "Why is the hall lamp not on?": '"why":"no command asked for that"',
    "What changed last night?": "kitchen_lamp: the client manager asked kitchen_lamp for level 40 %",
    "How warm was it today?": '"capability":"local_temperature"',
    "Wake me at 7!": "proposed Wake up; the owner enables it",
    "Close the blinds at sunset?": "would have given",
    "Which routines are there?": '"state":"proposed"',
}


@pytest.fixture
def world() -> World:
    tables = tomllib.loads(HOUSE.read_text("utf-8"))
    tables["devices"]["robot"]["dialect"] = "thesis"
    return parse_world(tables | {"house": {**tables["house"], "dialect": "homeassistant"}}, "family")


@asynccontextmanager
async def home(folder: Path, world: World) -> AsyncIterator[Api]:
    """The family house, with the file of a token that may do everything."""
    token, scope = TOKENS["manager"]
    (folder / "manager").write_text(token)
    (folder / "manager").chmod(0o600)
    tables = {
        "home": {"name": "villa", "latitude": 52.5, "longitude": 13.4},
        "people": {"Anna": {"ping": "127.0.0.1"}},
        "door": {"port": 0, "tokens": {"manager": {"token_file": str(folder / "manager"), "scope": scope}}},
        "gateways": {"mqtt": {}},
        "history": {"enabled": True},
    }
    async with (
        Runtime(parse_config(tables, "test"), house=world) as runtime,
        aiohttp.ClientSession() as session,
    ):
        assert runtime.rosbridge is not None
        api = Api(session, runtime.rosbridge.port)
        await api.until("/api/devices/nursery_heat", lambda found: "local_temperature" in found)
        await api.until("/api/devices?q=who+is+home", lambda found: bool(found.get("devices")))
        await api.until("/api/devices?q=light", lambda found: len(found["devices"]) == 8)
        await api.until("/api/devices?q=robot", lambda found: bool(found.get("devices")))
        yield api


@pytest.mark.parametrize("way", ["http", "stdio"])
async def test_twenty_questions_in_natural_words_are_answered_by_the_calls_of_the_guide(
    tmp_path: Path, world: World, way: str
) -> None:
    mcp: Any = pytest.importorskip("mcp.client.client")
    types: Any = pytest.importorskip("mcp.types")
    assert list(CALLS) == list(ANSWERS)
    asked: list[str] = []

    async def person(_: object, question: Any) -> Any:
        asked.append(question.message)
        return types.ElicitResult(action="accept", content={"confirm": True})

    wrong: dict[str, str] = {}
    async with (
        home(tmp_path, world) as api,
        connection(way, api, tmp_path) as streams,
        mcp.Client(streams, elicitation_callback=person) as session,
    ):
        for question, call in CALLS.items():
            assert isinstance(call, ast.Call)
            given = {one.arg: ast.literal_eval(one.value) for one in call.keywords}
            answer = await session.call_tool(ast.unparse(call.func), given)
            text = answer.content[0].text
            assert answer.is_error or answer.structured_content == json.loads(text)
            if GOES_ON in text:
                text += "\n".join(await trial_of(session, given["text"]))
            if ANSWERS[question] not in text:
                wrong[question] = text
    assert wrong == {}, json.dumps(wrong, indent=1)
    assert asked == ["front_lock: unlock? It always asks: it is a door lock."]


@asynccontextmanager
async def connection(way: str, api: Api, folder: Path) -> AsyncIterator[Any]:
    """The streams of a client of *api*, by HTTP or by a program that it starts."""
    if way == "http":
        http: Any = pytest.importorskip("mcp.client.streamable_http")
        httpx2: Any = pytest.importorskip("httpx2")
        headers = {"Authorization": bearer("manager")}
        async with httpx2.AsyncClient(headers=headers, timeout=PATIENCE, trust_env=False) as client:
            yield http.streamable_http_client(f"http://127.0.0.1:{api.port}/mcp", http_client=client)
    else:
        stdio: Any = pytest.importorskip("mcp.client.stdio")
        arguments = ["-m", "homebot", "mcp", "--door", f"127.0.0.1:{api.port}", "--token-file", str(folder / "manager")]
        yield stdio.stdio_client(stdio.StdioServerParameters(command=sys.executable, args=arguments))
