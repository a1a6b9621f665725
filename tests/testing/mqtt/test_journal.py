"""The messages kept for a test to expect."""

from __future__ import annotations

import anyio

from homebot.mqtt.broker.message import BrokerMessage
from homebot.testing.mqtt.journal import Journal


async def test_beyond_ten_thousand_the_oldest_message_is_forgotten_and_counted() -> None:
    journal = Journal()
    for number in range(10_003):
        journal.record(BrokerMessage("t", b"%d" % number, origin="lamp"))
    assert journal.forgotten == 3
    first = await journal.pop("t", None, 1.0)
    assert first is not None
    assert first.payload == b"3"


async def test_what_the_test_published_itself_is_not_kept() -> None:
    journal = Journal()
    journal.record(BrokerMessage("t", b"1"))
    assert journal.waiting("#") == []


async def test_only_one_of_two_that_wait_gets_the_message() -> None:
    journal = Journal()
    got: list[object] = []

    async def wait() -> None:
        got.append(await journal.pop("t", None, 0.05))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(wait)
        tasks.start_soon(wait)
        await anyio.lowlevel.checkpoint()
        journal.record(BrokerMessage("t", b"1", origin="lamp"))
    assert [each is None for each in got] == [False, True]
