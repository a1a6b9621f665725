"""Calls over one link get the answers that are meant for them; in virtual time."""

import anyio
import pytest

from homebot.errors import LinkError
from homebot.gateways.pending_calls import PendingCalls

pytestmark = pytest.mark.virtual_time


class Peer:
    """A peer that answers when it is told to.

    Attributes:
        calls: The calls to it.
        asked: The ids of those that it got.
        answers: What came of those that ended, by the word that each called.
    """

    def __init__(self) -> None:
        self.calls = PendingCalls[str]("the lamp")
        self.asked: list[str] = []
        self.answers: dict[str, str] = {}

    async def call(self, what: str) -> None:
        try:
            self.answers[what] = await self.calls.call(what, self._send, 5.0)
        except LinkError as exc:
            self.answers[what] = str(exc)

    async def _send(self, call_id: str) -> None:
        self.asked.append(call_id)


async def test_each_call_gets_its_own_answer_in_whatever_order_they_come() -> None:
    peer = Peer()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(peer.call, "one")
        tasks.start_soon(peer.call, "two")
        await anyio.wait_all_tasks_blocked()
        assert len(peer.calls) == 2
        first, second = peer.asked
        assert await peer.calls.resolve(second, "II")
        assert await peer.calls.resolve(first, "I")
    assert peer.answers == {"one": "I", "two": "II"}
    assert len(peer.calls) == 0


async def test_an_answer_without_a_waiting_call_is_none() -> None:
    peer = Peer()
    assert not await peer.calls.resolve("1", "I")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(peer.call, "one")
        await anyio.wait_all_tasks_blocked()
        assert await peer.calls.resolve(peer.asked[0], "I")
        assert not await peer.calls.resolve(peer.asked[0], "I again")
    assert peer.answers == {"one": "I"}


async def test_an_answer_is_handled_before_the_task_that_brought_it_goes_on() -> None:
    """Else what comes next would be handled before it."""
    calls, handled = PendingCalls[str]("the lamp"), list[str]()

    async def send(call_id: str) -> None:
        tasks.start_soon(bring, call_id)

    async def bring(call_id: str) -> None:
        await calls.resolve(call_id, "answer")
        handled.append("next")

    async def handle(answer: str) -> None:
        await anyio.sleep(1)
        handled.append(answer)

    async with anyio.create_task_group() as tasks:
        assert await calls.call("one", send, 5.0, handle) == "answer"
    assert handled == ["answer", "next"]


async def test_a_call_without_an_answer_ends_in_time() -> None:
    peer = Peer()
    await peer.call("one")
    assert peer.answers == {"one": "the lamp did not answer one within 5 s"}
    assert anyio.current_time() == 5.0
    assert not await peer.calls.resolve(peer.asked[0], "too late")


async def test_the_end_of_the_link_ends_calls_that_wait_and_later_ones() -> None:
    peer = Peer()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(peer.call, "one")
        await anyio.wait_all_tasks_blocked()
        peer.calls.end()
    await peer.call("two")
    lost = "the connection to the lamp was lost"
    assert peer.answers == {"one": lost, "two": lost}
    assert len(peer.asked) == 1
