"""``await publisher.send()``: what must not be dropped waits for room."""

import asyncio

import anyio
import pytest
from tests.graph.test_topic import Lamp, text, waiting

from homebot.errors import ClosedError, TypeMismatchError
from homebot.graph import Node, Publisher, QoSProfile, qos_profile_sensor_data
from homebot.messages import Bool, String


async def test_nothing_is_lost_however_slow_the_reader_is(node: Node) -> None:
    subscription = node.create_subscription(String, "t", qos_profile=1)
    publisher = node.create_publisher(String, "t")
    got: list[str] = []

    async def send_all() -> None:
        for number in range(50):
            await publisher.send(text(number))
        subscription.close()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(send_all)
        async for message in subscription:
            await anyio.wait_all_tasks_blocked()
            got.append(message.data)
    assert got == [str(number) for number in range(50)]
    assert subscription.lost == 0


async def test_a_callback_makes_room_too(node: Node) -> None:
    got: list[str] = []
    subscription = node.create_subscription(String, "t", lambda message: got.append(message.data), 1)
    publisher = node.create_publisher(String, "t")
    for number in range(50):
        await publisher.send(text(number))
    await anyio.wait_all_tasks_blocked()
    assert got == [str(number) for number in range(50)]
    assert subscription.lost == 0


async def test_with_room_or_without_readers_it_does_not_wait(node: Node) -> None:
    publisher = node.create_publisher(String, "t")
    with anyio.fail_after(0):
        await publisher.send(text(1))
        subscription = node.create_subscription(String, "t")
        await publisher.send(text(2))
    assert waiting(subscription) == ["2"]


async def test_a_best_effort_reader_is_not_waited_for(node: Node) -> None:
    subscription = node.create_subscription(String, "t", qos_profile=qos_profile_sensor_data)
    publisher = node.create_publisher(String, "t")
    with anyio.fail_after(0):
        for number in range(7):
            await publisher.send(text(number))
    assert subscription.lost == 2
    assert not publisher.is_full


async def test_a_cancelled_sender_sends_nothing_and_leaves_no_trace(node: Node) -> None:
    subscription = node.create_subscription(String, "t", qos_profile=1)
    publisher = node.create_publisher(String, "t")
    await publisher.send(text("first"))
    assert publisher.is_full
    for _ in range(100):
        with anyio.move_on_after(0):
            await publisher.send(text("never"))
    assert not subscription.mailbox.senders
    assert waiting(subscription) == ["first"]


async def test_a_cancelled_sender_gives_its_turn_to_the_next(node: Node) -> None:
    subscription = node.create_subscription(String, "t", qos_profile=1)
    publisher = node.create_publisher(String, "t")
    await publisher.send(text("first"))
    async with anyio.create_task_group() as tasks:
        given_up = asyncio.ensure_future(publisher.send(text("never")))
        await anyio.wait_all_tasks_blocked()
        tasks.start_soon(publisher.send, text("second"))
        await anyio.wait_all_tasks_blocked()
        assert waiting(subscription) == ["first"]
        given_up.cancel()  # admitted already, but not there yet
    assert given_up.cancelled()
    assert waiting(subscription) == ["second"]


async def test_one_who_waits_for_a_second_reader_does_not_keep_the_first_from_others(node: Node) -> None:
    """A is admitted by the quick reader, goes on to wait for the stuck one, and B must not wait beside a free place."""
    quick = node.create_subscription(String, "quick", qos_profile=1)
    stuck = node.create_subscription(String, "both", qos_profile=1)
    also_quick = node.create_subscription(String, "both", qos_profile=1)
    to_both = node.create_publisher(String, "both")
    await to_both.send(text("first"))
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(to_both.send, text("second"))
        tasks.start_soon(to_both.send, text("third"))
        await anyio.wait_all_tasks_blocked()
        assert waiting(also_quick) == ["first"]
        await anyio.wait_all_tasks_blocked()
        assert waiting(also_quick) == []
        assert waiting(stuck) == ["first"]
        await anyio.wait_all_tasks_blocked()
        assert waiting(also_quick) == ["second"]
        assert waiting(stuck) == ["second"]
    assert waiting(also_quick) == waiting(stuck) == ["third"]
    assert waiting(quick) == []


async def test_two_topics_into_one_place_do_not_block_each_other(node: Node) -> None:
    """The lost wake-up: the only free place was offered to a sender that could not use it."""
    shared = node.create_subscription(String, "shared", qos_profile=1)
    greedy, modest = node.create_publisher(String, "shared"), node.create_publisher(String, "shared")
    await modest.send(text(0))
    async with anyio.create_task_group() as tasks:
        for sender in (greedy, modest, greedy, modest):
            tasks.start_soon(sender.send, text(1))
        for _ in range(5):
            assert (await shared.receive()).data in {"0", "1"}
    assert shared.lost == 0


async def test_on_a_keyed_topic_it_waits_for_its_own_key(node: Node) -> None:
    subscription = node.create_subscription(Lamp, "lamps", qos_profile=1)
    publisher = node.create_publisher(Lamp, "lamps")
    await publisher.send(Lamp(id="a", on=True))
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(publisher.send, Lamp(id="a", on=False))
        await anyio.wait_all_tasks_blocked()
        with anyio.fail_after(0):
            await publisher.send(Lamp(id="b", on=True))
        assert subscription.take() == Lamp(id="a", on=True)
    assert (subscription.take(), subscription.take()) == (Lamp(id="b", on=True), Lamp(id="a", on=False))
    assert subscription.lost == 0


async def test_closing_the_reader_lets_the_sender_go(node: Node) -> None:
    subscription = node.create_subscription(String, "t", qos_profile=1)
    publisher = node.create_publisher(String, "t")
    await publisher.send(text(1))
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(publisher.send, text(2))
        await anyio.wait_all_tasks_blocked()
        subscription.close()
    assert waiting(subscription) == ["1"]


async def test_closing_the_publisher_ends_the_wait_with_an_error(node: Node) -> None:
    node.create_subscription(String, "t", qos_profile=1)
    publisher = node.create_publisher(String, "t")
    await publisher.send(text(1))
    sending = asyncio.create_task(publisher.send(text(2)))
    await anyio.wait_all_tasks_blocked()
    publisher.close()
    with pytest.raises(ClosedError, match=r"^the publisher of /node on /t is closed$"):
        await sending


async def test_a_wrong_message_is_refused_before_any_wait(node: Node) -> None:
    node.create_subscription(String, "t", qos_profile=1)
    publisher: Publisher[String] = node.create_publisher(String, "t", QoSProfile(depth=1))
    await publisher.send(text(1))
    with anyio.fail_after(0), pytest.raises(TypeMismatchError):
        await publisher.send(Bool(data=True))  # type: ignore[arg-type]  # the mistake under test
