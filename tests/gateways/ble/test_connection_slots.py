"""The queue for the few connections of an adapter."""

import anyio
import pytest
from anyio.abc import TaskGroup

from homebot.gateways.ble.connection_slots import ConnectionSlots

pytestmark = pytest.mark.virtual_time


class Queue:
    """Devices that ask for slots, and those that got one, in order."""

    def __init__(self, count: int, tasks: TaskGroup) -> None:
        self.in_range: set[str] = set()
        self.slots = ConnectionSlots(count, lambda key: key in self.in_range)
        self.got: list[str] = []
        self._tasks = tasks

    async def ask(self, *keys: str, far: bool = False) -> None:
        for key in keys:
            self.in_range |= set() if far else {key}
            self._tasks.start_soon(self._take, key)
        await anyio.wait_all_tasks_blocked()

    async def _take(self, key: str) -> None:
        await self.slots.acquire(key)
        self.got.append(key)


async def test_slots_are_given_in_the_order_of_asking_one_opening_at_a_time() -> None:
    async with anyio.create_task_group() as tasks:
        queue = Queue(2, tasks)
        await queue.ask("a", "b", "c")
        assert queue.got == ["a"]
        for key, expected in (("a", ["a", "b"]), ("b", ["a", "b"])):
            queue.slots.opened(key)
            await anyio.wait_all_tasks_blocked()
            assert queue.got == expected
        assert queue.slots.is_full_for("c")
        assert queue.slots.is_wanted
        queue.slots.release("a")
        await anyio.wait_all_tasks_blocked()
        assert queue.got == ["a", "b", "c"]
        assert not queue.slots.is_wanted


async def test_a_device_with_a_command_comes_first_also_out_of_range() -> None:
    async with anyio.create_task_group() as tasks:
        queue = Queue(1, tasks)
        await queue.ask("a", "b")
        await queue.ask("far", far=True)
        queue.slots.prefer("far")
        queue.slots.release("a")
        await anyio.wait_all_tasks_blocked()
        assert queue.got == ["a", "far"]
        queue.slots.unprefer("far")
        queue.slots.release("far")
        await anyio.wait_all_tasks_blocked()
        assert queue.got == ["a", "far", "b"]


async def test_a_device_out_of_range_delays_no_other_and_gets_its_slot_when_it_is_heard() -> None:
    async with anyio.create_task_group() as tasks:
        queue = Queue(2, tasks)
        await queue.ask("far", far=True)
        await queue.ask("near")
        queue.slots.opened("near")
        assert not queue.slots.is_wanted
        queue.in_range.add("far")
        queue.slots.notify()
        await anyio.wait_all_tasks_blocked()
        assert queue.got == ["near", "far"]


@pytest.mark.parametrize("was_granted", [True, False])
async def test_a_device_that_gives_up_leaves_its_place(was_granted: bool) -> None:  # noqa: FBT001 - a parameter
    async with anyio.create_task_group() as tasks:
        queue = Queue(1, tasks)
        await queue.ask("a")
        queue.in_range.add("b")
        with anyio.CancelScope() as scope:
            tasks.start_soon(_give_up, queue, scope, was_granted)
            await queue.slots.acquire("b")
            queue.slots.release("b")  # it got the slot before it could give up
        if not was_granted:
            queue.slots.release("a")
        await queue.ask("c")
        assert queue.got == ["a", "c"]


async def _give_up(queue: Queue, scope: anyio.CancelScope, was_granted: bool) -> None:  # noqa: FBT001 - likewise
    if was_granted:
        queue.slots.release("a")
    scope.cancel()
