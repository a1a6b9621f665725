"""What goes out to one client of the door: by turns, complete, and no more than may wait."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.time_slices import ServerTurns

pytestmark = pytest.mark.virtual_time


class Client:
    """Takes text while it is told to."""

    def __init__(self) -> None:
        self.got: list[object] = []
        self.takes = anyio.Event()
        self.is_cut = False

    async def send(self, text: str | bytes) -> None:
        await self.takes.wait()
        frame = json.loads(text)
        self.got.append(frame.get("id", frame.get("topic")))

    def cut(self) -> None:
        self.is_cut = True


class Topic:
    """Has a number of messages for the client."""

    def __init__(self, name: str, count: int, outbox: Outbox) -> None:
        self.name, self.left, self._outbox = name, count, outbox
        outbox.ready(self)

    def next_frame(self) -> str | None:
        if not self.left:
            return None
        self.left -= 1
        self._outbox.ready(self)
        return json.dumps({"op": "publish", "topic": self.name})


@asynccontextmanager
async def sending(client: Client, limit: int = 1000) -> AsyncIterator[Outbox]:
    outbox = Outbox(client.send, client.cut, ServerTurns(), limit)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(outbox.run)
        yield outbox
        await anyio.wait_all_tasks_blocked()
        tasks.cancel_scope.cancel()


def answer(identifier: str, size: int = 0) -> str:
    return json.dumps({"op": "service_response", "id": identifier, "values": "x" * size})


async def test_topics_and_answers_come_by_turns() -> None:
    client = Client()
    client.takes.set()
    async with sending(client) as outbox:
        Topic("/a", 3, outbox)
        Topic("/b", 3, outbox)
        for number in range(3):
            outbox.answer(answer(f"{number}"))
    assert client.got == ["0", "/a", "1", "/b", "2", "/a", "/b", "/a", "/b"]


async def test_whoever_wants_room_waits_until_the_client_took_its_answers() -> None:
    client = Client()
    async with sending(client, limit=1000) as outbox:
        outbox.answer(answer("a", 600))
        await outbox.room()
        outbox.answer(answer("b", 600))
        assert not outbox.has_room
        with anyio.move_on_after(60) as waited:
            await outbox.room()
        assert waited.cancelled_caught
        client.takes.set()
        with anyio.fail_after(1):
            await outbox.room()
    assert client.got == ["a", "b"]
    assert not client.is_cut


async def test_a_client_for_which_far_too_many_answers_wait_is_cut_off() -> None:
    client = Client()
    async with sending(client, limit=1000) as outbox:
        for number in range(10):
            outbox.answer(answer(f"{number}", 900))
    assert client.is_cut


async def test_an_answer_may_have_any_size() -> None:
    client = Client()
    client.takes.set()
    async with sending(client, limit=10) as outbox:
        outbox.answer(answer("big", 100_000))
    assert client.got == ["big"]
    assert not client.is_cut
