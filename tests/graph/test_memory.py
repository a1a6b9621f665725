"""Whatever is closed and let go of is gone at once, with all that it held: nothing waits for the garbage collector."""

import asyncio
import gc
import weakref
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import anyio
import pytest

from homebot.graph import Graph, Node, qos_profile_latched
from homebot.messages import SetBool, String
from homebot.messages.message import Message
from homebot.messages.std_srvs import SetBoolRequest, SetBoolResponse

pytestmark = pytest.mark.virtual_time


class Keyed(Message):
    """One state a key."""

    ros_type: ClassVar[str] = "test_msgs/msg/Keyed"
    key_field: ClassVar[str | None] = "key"

    key: str
    data: str = ""


MAKE: dict[type[Message], Callable[[int], Message]] = {
    String: lambda number: String(data=f"{number}"),
    Keyed: lambda number: Keyed(key=f"{number % 3}", data=f"{number}"),
}


@pytest.fixture(autouse=True)
def _without_the_collector() -> Iterator[None]:
    gc.disable()
    yield
    gc.enable()


def flood(node: Node, message_type: type[Message]) -> list[weakref.ref[Message]]:
    """Publish 50 messages; the publisher is gone afterwards."""
    publisher: Any = node.create_publisher(message_type, "t")
    messages = [MAKE[message_type](number) for number in range(50)]
    for message in messages:
        publisher.publish(message)
    publisher.close()
    return [weakref.ref(message) for message in messages]


def living(messages: list[weakref.ref[Message]]) -> int:
    return sum(one() is not None for one in messages)


@pytest.mark.parametrize("message_type", [String, Keyed])
async def test_a_closed_subscription_takes_its_unread_messages_along(graph: Graph, message_type: type[Message]) -> None:
    async with Node(graph, "n") as node:
        subscription = node.create_subscription(message_type, "t")
        messages = flood(node, message_type)
        assert living(messages) > 0
        subscription.close()
        del subscription
        assert living(messages) == 0


@pytest.mark.parametrize(("concurrent", "under_way"), [(False, 0), (True, 10)])
@pytest.mark.parametrize("message_type", [String, Keyed])
async def test_a_closed_node_takes_along_what_its_callbacks_did_not_get_to(
    graph: Graph, message_type: type[Message], *, concurrent: bool, under_way: int
) -> None:
    """Only what concurrent callbacks were busy with may stay a while: in the traceback of their cancellation."""

    async def never_done(_message: Message) -> None:
        await anyio.sleep_forever()

    async with Node(graph, "talker") as talker:
        async with Node(graph, "n") as node:
            node.create_subscription(message_type, "t", never_done, concurrent=concurrent)
            messages = flood(talker, message_type)
            await anyio.wait_all_tasks_blocked()
            assert living(messages) > 0
            node.close()
            await anyio.wait_all_tasks_blocked()
        del node
        assert living(messages) <= under_way


@pytest.mark.parametrize("message_type", [String, Keyed])
async def test_a_closed_publisher_takes_along_what_it_kept_for_late_joiners(
    graph: Graph, message_type: type[Message]
) -> None:
    async with Node(graph, "n") as node:
        publisher: Any = node.create_publisher(message_type, "t", qos_profile_latched)
        message = MAKE[message_type](1)
        publisher.publish(message)
        messages = [weakref.ref(message)]
        del message
        assert living(messages) == 1
        publisher.close()
        assert living(messages) == 0


async def test_whatever_is_closed_is_gone_itself(graph: Graph) -> None:
    """Not only its messages: a program that subscribes, publishes and calls all day leaves nothing behind."""
    async with Node(graph, "n") as node:
        entities: list[Any] = [
            node.create_subscription(String, "t"),
            node.create_publisher(String, "t"),
            node.create_client(SetBool, "s"),
            node.create_service(SetBool, "s", _switch),
        ]
        left = [weakref.ref(entity) for entity in entities]
        while entities:
            entities.pop().close()
        assert [one() for one in left] == [None] * 4


def _switch(request: SetBoolRequest) -> SetBoolResponse:
    return SetBoolResponse(success=request.data, message="")


async def test_clients_of_a_single_call_leave_one_timer_of_the_loop_together() -> None:
    """Each request of the door left its own, for up to an hour."""

    async def answer(_request: SetBoolRequest) -> SetBoolResponse:
        await anyio.sleep(1)
        return SetBoolResponse(success=True, message="")

    async with Node(Graph(), "door") as node:
        node.create_service(SetBool, "s", answer)
        before = running_timers()
        for _ in range(50):
            client = node.create_client(SetBool, "s")
            await client.call(SetBoolRequest(data=True), 3_600.0)
            client.close()
        assert running_timers() - before <= 1


def running_timers() -> int:
    return sum(type(one) is asyncio.TimerHandle and not one.cancelled() for one in gc.get_objects())
