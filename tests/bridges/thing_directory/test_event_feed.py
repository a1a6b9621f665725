"""Events of the list: a client that is behind too far is cut off, and silence is broken."""

import anyio
import pytest

from homebot.bridges.thing_directory.catalog import MAX_CHANGES, ThingCatalog
from homebot.bridges.thing_directory.event_feed import EventFeed
from homebot.wot.thing import THING_CHANGES

pytestmark = pytest.mark.virtual_time


class SlowClient:
    """A client that takes a piece when it is allowed to."""

    def __init__(self) -> None:
        self.taken: list[bytes] = []
        self.may_take = anyio.Semaphore(1)

    async def send(self, piece: bytes) -> None:
        await self.may_take.acquire()
        self.taken.append(piece)


async def test_a_client_that_is_behind_too_far_is_cut_off_and_counted() -> None:
    catalog, client = ThingCatalog(), SlowClient()
    feed = EventFeed(catalog, "run")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(feed.run, client, THING_CHANGES)
        await anyio.wait_all_tasks_blocked()
        catalog.put("a", {"id": "a"}, "now")
        feed.notify()
        await anyio.wait_all_tasks_blocked()  # it does not take the first event
        for number in range(MAX_CHANGES + 1):
            catalog.put("a", {"id": "a", "title": number}, "now")
        assert feed.clients == 1
        client.may_take.release()
    assert feed.overtaken == 1
    assert feed.clients == 0
    assert len(client.taken) == 2


async def test_a_silent_stream_is_kept_alive_and_ends_with_the_directory() -> None:
    client = SlowClient()
    feed = EventFeed(ThingCatalog(), "run")
    for _ in range(10):
        client.may_take.release()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(feed.run, client, THING_CHANGES)
        await anyio.sleep(50)
        assert client.taken == [b"retry: 2000\n\n", b":\n\n", b":\n\n", b":\n\n"]
        feed.close()


@pytest.mark.parametrize("last_id", ["", "run-", "run-x", "run-99", "other-0", "run-²", f"run-{'9' * 5000}", "-1"])
async def test_after_an_unknown_id_only_new_changes_are_sent(last_id: str) -> None:
    catalog, client = ThingCatalog(), SlowClient()
    catalog.put("a", {"id": "a"}, "now")
    feed = EventFeed(catalog, "run")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(feed.run, client, THING_CHANGES, last_id)
        await anyio.wait_all_tasks_blocked()
        assert client.taken == [b"retry: 2000\n\n"]
        feed.close()
