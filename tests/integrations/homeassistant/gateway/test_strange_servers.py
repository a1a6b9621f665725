"""The Home Assistant gateway at an address where something else answers, or nothing does."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import anyio
import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from homebot.errors import LinkError
from homebot.integrations.homeassistant.gateway import HomeAssistantGateway, HomeAssistantGatewaySettings
from homebot.integrations.homeassistant.gateway.link import connected

pytestmark = pytest.mark.slow

REQUIRED = json.dumps({"type": "auth_required", "ha_version": "2026.1.0"})
LOGGED_IN = json.dumps({"type": "auth_ok", "ha_version": "2026.1.0"})
LONG = "x" * 1_000_000


@asynccontextmanager
async def settings_of(
    folder: Path, handle: Callable[[ServerConnection], Awaitable[None]]
) -> AsyncIterator[HomeAssistantGatewaySettings]:
    (folder / "token").touch(0o600)
    (folder / "token").write_text("a-token")
    async with serve(handle, "127.0.0.1", 0, compression=None) as server:
        url = f"http://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}"
        yield HomeAssistantGatewaySettings.model_validate({"url": url, "token_file": folder / "token"})


@pytest.mark.parametrize("first", ["", REQUIRED])
@pytest.mark.parametrize("kind", ["frames", "pieces of one frame"])
async def test_endless_frames_before_the_login_are_cut_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, first: str, kind: str
) -> None:
    """They cost 300 MiB."""
    sent, loop = 0, asyncio.get_running_loop()
    now = loop.time()
    monkeypatch.setattr(loop, "time", lambda: now)  # a slow machine takes longer than the five seconds

    async def pieces() -> AsyncIterator[str]:
        nonlocal sent
        while True:
            yield LONG
            sent += len(LONG)

    async def flood(peer: ServerConnection) -> None:
        if first:
            await peer.send(first)
        with suppress(ConnectionClosed):
            while True:
                await peer.send(LONG * 30 if kind == "frames" else pieces())

    async with settings_of(tmp_path, flood) as settings:
        with pytest.raises(LinkError, match=r"closed the connection|was lost"):
            await HomeAssistantGateway.reach(settings)
    assert sent <= 20 * len(LONG)  # which the operating system buffers


@pytest.mark.parametrize("first", ["", REQUIRED])
async def test_one_that_answers_nothing_is_told_within_five_seconds(tmp_path: Path, first: str) -> None:
    async def wait(peer: ServerConnection) -> None:
        if first:
            await peer.send(first)
        await peer.wait_closed()

    async with settings_of(tmp_path, wait) as settings:
        with pytest.raises(LinkError, match="did not greet within 5 s"):
            await HomeAssistantGateway.reach(settings)


async def test_frames_after_the_login_may_be_long(tmp_path: Path) -> None:
    async def answer(peer: ServerConnection) -> None:
        await peer.send(REQUIRED)
        await peer.recv()
        await peer.send(LOGGED_IN)
        asked = json.loads(await peer.recv())
        await peer.send(json.dumps({"id": asked["id"], "type": "result", "success": True, "result": LONG}))
        await peer.wait_closed()

    async with (
        settings_of(tmp_path, answer) as settings,
        connected(settings, lambda *_: None) as link,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(link.read)
        assert await link.call("the configuration", "get_config") == LONG
        tasks.cancel_scope.cancel()
