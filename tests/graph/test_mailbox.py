"""The bounded queue with one reader."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import anyio
import pytest
from anyio.lowlevel import checkpoint

from homebot.errors import ClosedError, UsageError
from homebot.graph.mailbox import TURN, KeyedQueue, Mailbox, keyed_queue


async def test_items_come_in_order() -> None:
    mailbox: Mailbox[int] = Mailbox(3)
    for item in (1, 2, 3):
        mailbox.put(item)
    assert [await mailbox.receive() for _ in range(3)] == [1, 2, 3]
    assert mailbox.take() is None


async def test_a_full_mailbox_drops_its_oldest_item_and_counts_it() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    for item in (1, 2, 3, 4):
        mailbox.put(item)
    assert (mailbox.take(), mailbox.take(), mailbox.take()) == (3, 4, None)
    assert mailbox.lost == 2


async def test_a_waiting_reader_is_woken() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    got: list[int] = []

    async def read() -> None:
        got.append(await mailbox.receive())

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await anyio.wait_all_tasks_blocked()
        mailbox.put(1)
    assert got == [1]


async def test_an_item_is_not_lost_when_its_reader_is_cancelled_on_the_way_to_it() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    reader = asyncio.ensure_future(mailbox.receive())
    await anyio.wait_all_tasks_blocked()
    mailbox.put(1)
    reader.cancel()
    with pytest.raises(asyncio.CancelledError):
        await reader
    assert mailbox.take() == 1


async def test_a_reader_may_come_back_after_it_was_cancelled() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    with anyio.move_on_after(0):
        await mailbox.receive()
    mailbox.put(1)
    assert await mailbox.receive() == 1


async def test_a_second_waiting_reader_is_refused() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(mailbox.receive)
        await anyio.wait_all_tasks_blocked()
        with pytest.raises(UsageError, match="two tasks read"):
            await mailbox.receive()
        tasks.cancel_scope.cancel()


async def test_what_waits_at_the_close_can_still_be_read() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    mailbox.put(1)
    mailbox.close()
    mailbox.close()
    mailbox.put(2)
    assert [item async for item in mailbox] == [1]
    with pytest.raises(ClosedError):
        await mailbox.receive()


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


async def test_waiting_for_an_item_returns_at_once_when_one_is_there() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    mailbox.put(1)
    await mailbox.wait()
    assert mailbox.take() == 1


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


async def test_a_reader_that_never_waits_can_be_cancelled() -> None:
    mailbox: Mailbox[int] = Mailbox(2)
    mailbox.put(0)
    with anyio.CancelScope() as scope:
        scope.cancel()
        while True:
            mailbox.put(await mailbox.receive())
    assert scope.cancelled_caught


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


async def test_one_who_waits_for_room_and_is_cancelled_leaves_no_trace() -> None:
    mailbox: Mailbox[int] = Mailbox(1)
    mailbox.put(1)
    with anyio.move_on_after(0):
        await mailbox.wait_for_change()
    assert not mailbox.senders


async def test_one_who_is_admitted_and_cancelled_at_once_is_cancelled() -> None:
    mailbox: Mailbox[int] = Mailbox(1)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(mailbox.wait_for_change)
        await anyio.wait_all_tasks_blocked()
        mailbox.admit_senders()
        tasks.cancel_scope.cancel()
    assert not mailbox.senders


async def test_an_admission_passes_over_one_whose_cancellation_is_under_way() -> None:
    mailbox: Mailbox[int] = Mailbox(1)
    task = asyncio.ensure_future(mailbox.wait_for_change())
    await checkpoint()
    task.cancel()
    mailbox.admit_senders()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert not mailbox.senders


def test_a_closed_mailbox_has_room_for_everything() -> None:
    mailbox: Mailbox[int] = Mailbox(1)
    mailbox.put(1)
    assert not mailbox.has_room_for(2)
    mailbox.close()
    assert mailbox.has_room_for(2)


def keyed(depth: int = 1) -> Mailbox[str]:
    return Mailbox(depth, key=lambda item: item[0])


def test_a_keyed_mailbox_keeps_the_newest_of_each_key_in_order_of_arrival() -> None:
    mailbox = keyed()
    for item in ("a1", "b1", "a2", "c1", "b2"):
        mailbox.put(item)
    assert [mailbox.take() for _ in range(4)] == ["a2", "c1", "b2", None]
    assert mailbox.lost == 2


def test_the_depth_of_a_keyed_mailbox_is_per_key() -> None:
    mailbox = keyed(depth=2)
    for item in ("a1", "a2", "a3", "b1"):
        mailbox.put(item)
    assert [mailbox.take() for _ in range(3)] == ["a2", "a3", "b1"]


def test_room_in_a_keyed_mailbox_is_room_under_the_key() -> None:
    mailbox = keyed()
    mailbox.put("a1")
    assert not mailbox.has_room_for("a2")
    assert mailbox.has_room_for("b1")


@pytest.fixture
def losses() -> list[int]:
    return []


@pytest.fixture
def small(losses: list[int], monkeypatch: pytest.MonkeyPatch) -> Callable[[int], KeyedQueue[str]]:
    """Make a keyed queue that holds three items over all keys."""
    monkeypatch.setattr("homebot.graph.mailbox.MAX_KEYED_ITEMS", 3)
    return lambda depth: keyed_queue(depth, lambda item: item[0], lambda _item: losses.append(1))


def test_too_many_keys_push_out_the_oldest_item_of_all(
    small: Callable[[int], KeyedQueue[str]], losses: list[int]
) -> None:
    queue = small(1)
    for item in ("a1", "b1", "c1", "d1"):
        queue.append(item)
    assert list(queue) == ["b1", "c1", "d1"]
    assert losses == [1]
    assert not queue.has_room_for("e1")


def test_replacing_an_item_in_a_full_queue_costs_no_other(
    small: Callable[[int], KeyedQueue[str]], losses: list[int]
) -> None:
    queue = small(1)
    for item in ("a1", "b1", "c1", "a2"):
        queue.append(item)
    assert list(queue) == ["b1", "c1", "a2"]
    assert losses == [1]


def test_the_bound_holds_also_where_the_pushed_out_item_is_of_the_same_key(
    small: Callable[[int], KeyedQueue[str]],
) -> None:
    queue = small(3)
    for item in ("a1", "b1", "b2", "a2"):
        queue.append(item)
    assert list(queue) == ["b1", "b2", "a2"]
    assert queue.popleft() == "b1"


def test_a_key_can_be_forgotten(small: Callable[[int], KeyedQueue[str]], losses: list[int]) -> None:
    queue = small(2)
    for item in ("a1", "b1", "a2"):
        queue.append(item)
    queue.discard("a")
    queue.discard("x")
    assert list(queue) == ["b1"]
    assert losses == []
