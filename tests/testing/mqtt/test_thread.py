"""The way to the brokers' thread."""

import asyncio
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.testing.mqtt import BrokerThread, TestBroker, broker_thread
from homebot.testing.mqtt.journal import RecordedMessage


@pytest.fixture
def thread() -> Iterator[BrokerThread]:
    with broker_thread() as thread:
        yield thread


async def fails() -> None:
    pytest.fail("on purpose")


async def test_what_is_raised_there_reaches_the_caller_and_ends_nothing(thread: BrokerThread) -> None:
    with pytest.raises(pytest.fail.Exception, match="on purpose"):
        await thread.run(fails)
    assert await thread.run(asyncio.sleep, 0, "alive") == "alive"


def test_the_same_holds_without_a_loop(thread: BrokerThread) -> None:
    with pytest.raises(pytest.fail.Exception, match="on purpose"):
        thread.call(fails)
    assert thread.call(asyncio.sleep, 0, "alive") == "alive"


async def test_a_cancelled_caller_cancels_the_work(thread: BrokerThread) -> None:
    begun, ended = anyio.Event(), anyio.Event()
    home = asyncio.get_running_loop()

    async def work() -> None:
        home.call_soon_threadsafe(begun.set)
        try:
            await anyio.sleep_forever()
        finally:
            home.call_soon_threadsafe(ended.set)

    with anyio.fail_after(PATIENCE):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(thread.run, work)
            await begun.wait()
            tasks.cancel_scope.cancel()
        await ended.wait()


async def test_a_thread_that_does_not_run_says_so() -> None:
    with pytest.raises(RuntimeError, match="broker thread is not running"):
        await BrokerThread().run(fails)


def test_who_waits_when_the_thread_ends_is_told_so() -> None:
    begun = threading.Event()

    async def work() -> None:
        begun.set()
        await anyio.sleep_forever()

    with ThreadPoolExecutor() as others:
        with broker_thread() as thread:
            call = others.submit(thread.call, work)
            assert begun.wait(30)
        with pytest.raises(RuntimeError, match="has ended"):
            call.result(5)
    with pytest.raises(RuntimeError, match="broker thread is not running"):
        thread.call(work)


def test_the_thread_refuses_to_block_itself(thread: BrokerThread) -> None:
    async def work() -> None:
        thread.call(fails)

    with pytest.raises(RuntimeError, match="would block"):
        thread.call(work)


async def test_a_predicate_that_fails_the_test_fails_it_at_once(mqtt_broker: TestBroker) -> None:
    reader, writer = await asyncio.open_connection(mqtt_broker.host, mqtt_broker.port)
    writer.write(bytes.fromhex("100d00044d5154540402003c000161") + bytes.fromhex("30050001743637"))
    await reader.readexactly(4)

    def wrong(message: RecordedMessage) -> bool:
        pytest.fail(f"{message.topic} is wrong")

    with pytest.raises(pytest.fail.Exception, match="t is wrong"):
        await mqtt_broker.expect("t", wrong)
    assert (await mqtt_broker.expect("t")).text == "67"
    writer.close()
    await writer.wait_closed()
