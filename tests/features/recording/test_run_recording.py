"""The recorder for a client: one at a time, and free again when the client is gone."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.config import parse_config
from homebot.features.recording import READ_RECORDING, START_RECORDER
from homebot.features.recording.session import ReadRecording, ReadRecordingRequest, ReadRecordingResponse
from homebot.graph import Client, Node
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.runtime import Runtime

Reader = Client[ReadRecordingRequest, ReadRecordingResponse]


pytestmark = pytest.mark.virtual_time


@asynccontextmanager
async def running_app() -> AsyncIterator[Node]:
    config = parse_config({"discovery": {"persist": False}}, "test")
    async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "app") as node:
        yield node


async def start(app: Node) -> SuccessResponse:
    return await app.create_client(Trigger, START_RECORDER.name).call(TriggerRequest())


async def read_all(app: Node) -> Reader:
    """Fetch what there is at the beginning; the next request waits."""
    reader = app.create_client(ReadRecording, READ_RECORDING.name)
    while (await reader.call(ReadRecordingRequest())).lines:
        pass
    return reader


async def test_a_client_that_leaves_while_it_waits_for_lines_makes_room_at_once() -> None:
    """A ``homebot record`` that is killed: its connection closes, and its call is cancelled."""
    async with running_app() as app:
        assert (await start(app)).success
        reader = await read_all(app)
        assert "another client is recording" in (await start(app)).message
        left_at = app.graph.clock.monotonic()
        with anyio.move_on_after(0.5):
            await reader.call(ReadRecordingRequest())
        await anyio.wait_all_tasks_blocked()
        assert (await start(app)).success
        assert app.graph.clock.monotonic() - left_at < 1


async def test_a_client_that_fetches_nothing_makes_room_after_ten_seconds() -> None:
    async with running_app() as app:
        assert (await start(app)).success
        await read_all(app)
        await anyio.sleep(8.5)
        assert not (await start(app)).success
        await anyio.sleep(1)
        assert (await start(app)).success
