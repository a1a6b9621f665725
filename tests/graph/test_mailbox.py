"""The bounded queue with one reader."""

import asyncio
from collections.abc import Callable

import anyio
import pytest
from anyio.lowlevel import checkpoint

from homebot.graph.mailbox import MAX_KEYED_ITEMS, TURN, KeyedQueue, Mailbox, keyed_queue


async def test_an_item_is_not_lost_when_its_reader_is_cancelled_on_the_way_to_it() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    reader = asyncio.ensure_future(mailbox.receive())
    await anyio.wait_all_tasks_blocked()
    mailbox.put(1)
    reader.cancel()
    with pytest.raises(asyncio.CancelledError):
        await reader
    assert mailbox.take() == 1


async def test_closing_ends_a_waiting_iteration() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    got: list[int] = []

    async def read() -> None:
        got.extend([item async for item in mailbox])

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await anyio.wait_all_tasks_blocked()
        mailbox.put(1)
        await anyio.wait_all_tasks_blocked()
        mailbox.close()
    assert got == [1]


async def test_a_reader_that_feeds_itself_lets_others_run() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    mailbox.put(0)
    turns: list[int] = []

    async def other() -> None:
        turns.append(1)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(other)
        count = 0
        while not turns:
            mailbox.put(await mailbox.receive())
            count += 1
        assert count <= TURN


async def test_all_who_wait_for_room_look_again_when_an_item_is_taken() -> None:
    mailbox: Mailbox[int] = Mailbox(1)
    mailbox.put(1)
    woken: list[str] = []

    async def wait(name: str) -> None:
        await mailbox.wait_for_change()
        woken.append(name)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(wait, "first")
        tasks.start_soon(wait, "second")
        await anyio.wait_all_tasks_blocked()
        assert mailbox.take() == 1
        await anyio.wait_all_tasks_blocked()
        assert woken == ["first", "second"]


async def test_an_admission_passes_over_one_whose_cancellation_is_under_way() -> None:
    mailbox: Mailbox[int] = Mailbox(1)
    task = asyncio.ensure_future(mailbox.wait_for_change())
    await checkpoint()
    task.cancel()
    mailbox.admit_senders()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert not mailbox.senders


@pytest.fixture
def losses() -> list[int]:
    return []


@pytest.fixture
def nearly_full(losses: list[int]) -> Callable[[int], KeyedQueue[str]]:
    """Make a keyed queue with a key for all but its last three items; they are taken first."""

    def make(depth: int) -> KeyedQueue[str]:
        queue: KeyedQueue[str] = keyed_queue(depth, lambda item: item[:-1], lambda _item: losses.append(1))
        for item in ("a1", "b1"):
            queue.append(item)
        for number in range(MAX_KEYED_ITEMS - 3):
            queue.append(f"{number}-")
        queue.append("c1")
        return queue

    return make


def ends(queue: KeyedQueue[str]) -> list[str]:
    """The items but those that fill the queue."""
    assert len(queue) == MAX_KEYED_ITEMS
    return [one for one in queue if not one.endswith("-")]


def test_too_many_keys_push_out_the_oldest_item_of_all(
    nearly_full: Callable[[int], KeyedQueue[str]], losses: list[int]
) -> None:
    queue = nearly_full(1)
    assert not losses
    queue.append("d1")
    assert ends(queue) == ["b1", "c1", "d1"]
    assert losses == [1]
    assert not queue.has_room_for("e1")


def test_replacing_an_item_in_a_full_queue_costs_no_other(
    nearly_full: Callable[[int], KeyedQueue[str]], losses: list[int]
) -> None:
    queue = nearly_full(1)
    queue.append("a2")
    assert ends(queue) == ["b1", "c1", "a2"]
    assert losses == [1]


def test_the_bound_holds_also_where_the_pushed_out_item_is_of_the_same_key(
    nearly_full: Callable[[int], KeyedQueue[str]],
) -> None:
    queue = nearly_full(3)
    queue.append("a2")
    assert ends(queue) == ["b1", "c1", "a2"]
    assert queue.popleft() == "b1"
