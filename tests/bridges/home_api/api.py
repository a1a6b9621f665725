"""A running homebot with a simulated house, and an independent client of its HTTP API."""

import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, NamedTuple

import aiohttp
import anyio
from tests.patience import PATIENCE
from websockets.asyncio.client import ClientConnection, connect

from homebot.config import parse_config
from homebot.house import SimulatedLamp, World
from homebot.house.devices import SimulatedDoorLock
from homebot.runtime import Runtime

TOKENS = {
    "agent": ("agent-token-1234567", ["read", "act: harmless"]),
    "asker": ("asker-token-1234567", ["read", "act: harmless", "ask: lock"]),
    "keys": ("keys-token-12345678", ["read", "act: all"]),
    "manager": ("manager-token-12345", ["read", "act: all", "manage"]),
    "reader": ("reader-token-123456", ["read"]),
}
HISTORY = {"history": {"enabled": True}}


class Answer(NamedTuple):
    """An answer, with the size of its body."""

    status: int
    values: Any
    size: int
    content_type: str


class Api:
    """A client of the HTTP API."""

    def __init__(self, session: aiohttp.ClientSession, port: int) -> None:
        self._session = session
        self.port = port

    async def get(self, path: str, **headers: str) -> Answer:
        return await self._ask("GET", path, headers)

    async def command(self, device: str | list[str], do: str, **headers: str) -> Answer:
        return await self._ask("POST", "/api/command", headers, json={"device": device, "do": do})

    async def scene(self, name: str, *, undo: bool = False, **headers: str) -> Answer:
        return await self._ask("POST", "/api/scene", headers, json={"scene": name, "undo": undo})

    async def propose(self, text: str, **headers: str) -> Answer:
        return await self._ask("POST", "/api/routines", headers, json={"text": text})

    async def achieve(self, goal: str, **headers: str) -> Answer:
        return await self._ask("POST", "/api/goal", headers, json={"goal": goal, "dry_run": True})

    async def save(self, name: str, values: dict[str, str]) -> None:
        """Save a scene at the door, as the person who has its rights."""
        async with connect(f"ws://127.0.0.1:{self.port}", proxy=None) as door:
            given = [{"key": key, "value": value} for key, value in values.items()]
            answer = await _called(door, "/scenes/change", name=name, change="save", values=given)
        assert answer["success"], answer

    @asynccontextmanager
    async def answering(self, *answers: bool) -> AsyncIterator[list[str]]:
        """Answer as many questions at the door, as the person who has its rights; yield their texts."""
        asked: list[str] = []

        async def answer() -> None:
            async with connect(f"ws://127.0.0.1:{self.port}", proxy=None) as door:
                for yes in answers:
                    while not (found := (await _called(door, "/control/get_questions"))["questions"]):  # noqa: ASYNC110
                        await anyio.sleep(0.05)
                    asked.append(found[0]["text"])
                    await _called(door, "/control/answer", question=found[0]["question"], yes=yes)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(answer)
            yield asked

    async def until(self, path: str, is_so: Callable[[Any], bool]) -> None:
        with anyio.fail_after(PATIENCE):
            while not is_so((await self.get(path)).values):  # noqa: ASYNC110 - it is seen from outside
                await anyio.sleep(0.05)

    async def _ask(self, method: str, path: str, headers: dict[str, str], **more: Any) -> Answer:
        url = f"http://127.0.0.1:{self.port}{path}"
        given = {name.replace("_", "-"): value for name, value in headers.items()}
        async with self._session.request(method, url, headers=given, **more) as answer:
            body = await answer.read()
            return Answer(answer.status, json.loads(body), len(body), answer.content_type)


async def _called(door: ClientConnection, service: str, **args: object) -> Any:
    await door.send(json.dumps({"op": "call_service", "service": service, "args": args}))
    with anyio.fail_after(PATIENCE):
        return json.loads(await door.recv())["values"]


def bearer(name: str) -> str:
    return f"Bearer {TOKENS[name][0]}"


@asynccontextmanager
async def running_api(folder: Path, **more: object) -> AsyncIterator[Api]:
    """Run a house of four lamps and a lock, whose tokens are in *folder*, with *more* tables of the configuration."""
    tokens = {}
    for name, (token, scope) in TOKENS.items():
        (folder / name).write_text(token)
        (folder / name).chmod(0o600)
        tokens[name] = {"token_file": str(folder / name), "scope": scope}
    tables = {
        "home": {"name": "villa"},
        "places": {"devices": {"lights/lamp4": {"aliases": ["Door stop"]}}},
        "door": {"port": 0, "tokens": tokens},
        "gateways": {"mqtt": {"root": "home425"}},
        **more,
    }
    lamps = [SimulatedLamp(f"lamp{number}") for number in range(1, 5)]
    async with (
        Runtime(parse_config(tables, "test"), house=World.of(*lamps, SimulatedDoorLock("front_door"))) as runtime,
        aiohttp.ClientSession() as session,
    ):
        assert runtime.rosbridge is not None
        api = Api(session, runtime.rosbridge.port)
        await api.until("/api/home", lambda found: found.get("devices") == 5)
        yield api
