"""Topics: publishing, queues, late joiners, keys, lifespans and mismatches."""

from collections.abc import Awaitable, Callable
from typing import ClassVar

import anyio
import pytest
from structlog.testing import capture_logs
from tests.call_counts import calls

from homebot.errors import ClosedError, InvalidNameError, QosError, TypeMismatchError
from homebot.graph import (
    DurabilityPolicy,
    Graph,
    Node,
    QoSProfile,
    ReliabilityPolicy,
    Subscription,
    qos_profile_latched,
    qos_profile_sensor_data,
)
from homebot.messages import Bool, Message, String

LATCHED_3 = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Lamp(Message):
    key_field: ClassVar[str | None] = "id"

    id: str
    on: bool


class Wrapped(Message):
    key_field: ClassVar[str | None] = "lamp.id"

    lamp: Lamp


def text(data: object) -> String:
    return String(data=str(data))


def waiting(subscription: Subscription[String]) -> list[str]:
    """Take all that waits."""
    return [message.data for message in iter(subscription.take, None)]


async def test_every_subscription_gets_every_message_itself(node: Node) -> None:
    one, other = node.create_subscription(String, "t"), node.create_subscription(String, "/t")
    publisher = node.create_publisher(String, "t")
    message = text(1)
    publisher.publish(message)
    assert one.take() is message
    assert other.take() is message
    assert publisher.subscription_count == 2


async def test_one_more_subscription_costs_the_same_beside_many(graph: Graph) -> None:
    """As hundreds of routines subscribe to the same topics."""
    async with Node(graph, "publisher") as one, Node(graph, "reader") as reader:
        one.create_publisher(String, "/t")
        first, *_, last = [calls(lambda: reader.create_subscription(String, "/t")) for _ in range(100)][1:]
    assert last < first + 20


async def test_a_full_queue_keeps_the_newest_and_counts_the_loss(node: Node) -> None:
    slow, fast = node.create_subscription(String, "t", qos_profile=2), node.create_subscription(String, "t")
    publisher = node.create_publisher(String, "t")
    for number in range(5):
        publisher.publish(text(number))
    assert waiting(slow) == ["3", "4"]
    assert (slow.lost, fast.lost) == (3, 0)
    assert waiting(fast) == ["0", "1", "2", "3", "4"]


async def test_a_late_joiner_gets_what_is_kept_oldest_first_before_what_is_live(node: Node) -> None:
    publisher = node.create_publisher(String, "t", LATCHED_3)
    for number in range(5):
        publisher.publish(text(number))
    late = node.create_subscription(String, "t", qos_profile=QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL))
    publisher.publish(text("live"))
    assert waiting(late) == ["2", "3", "4", "live"]
    assert late.lost == 0


async def test_a_volatile_late_joiner_gets_new_messages_only(node: Node) -> None:
    publisher = node.create_publisher(String, "t", LATCHED_3)
    publisher.publish(text("old"))
    late = node.create_subscription(String, "t")
    publisher.publish(text("new"))
    assert waiting(late) == ["new"]


async def test_asking_for_less_history_than_is_kept_is_no_loss(node: Node) -> None:
    publisher = node.create_publisher(String, "t", LATCHED_3)
    for number in range(3):
        publisher.publish(text(number))
    late = node.create_subscription(String, "t", qos_profile=qos_profile_latched)
    assert waiting(late) == ["2"]
    assert late.lost == 0


async def test_what_is_kept_goes_with_its_publisher(node: Node) -> None:
    publisher = node.create_publisher(String, "t", LATCHED_3)
    publisher.publish(text(1))
    publisher.close()
    assert waiting(node.create_subscription(String, "t", qos_profile=qos_profile_latched)) == []


async def test_a_late_joiner_hears_every_publisher(node: Node) -> None:
    for number in range(2):
        node.create_publisher(String, "t", qos_profile_latched).publish(text(number))
    late = node.create_subscription(String, "t", qos_profile=LATCHED_3)
    assert waiting(late) == ["0", "1"]


async def test_a_keyed_topic_keeps_the_newest_of_each_key_for_a_slow_reader(node: Node) -> None:
    slow = node.create_subscription(Lamp, "lamps", qos_profile=1)
    publisher = node.create_publisher(Lamp, "lamps")
    for lamp in (Lamp(id="a", on=True), Lamp(id="b", on=True), Lamp(id="a", on=False)):
        publisher.publish(lamp)
    assert (slow.take(), slow.take(), slow.take()) == (Lamp(id="b", on=True), Lamp(id="a", on=False), None)
    assert slow.lost == 1


async def test_a_keyed_topic_keeps_the_newest_of_each_key_for_late_joiners(node: Node) -> None:
    publisher = node.create_publisher(Lamp, "lamps", qos_profile_latched)
    for lamp in (Lamp(id="a", on=True), Lamp(id="b", on=True), Lamp(id="c", on=True), Lamp(id="a", on=False)):
        publisher.publish(lamp)
    publisher.dispose("c")
    late = node.create_subscription(Lamp, "lamps", qos_profile=qos_profile_latched)
    assert (late.take(), late.take(), late.take()) == (Lamp(id="b", on=True), Lamp(id="a", on=False), None)
    assert late.lost == 0


async def test_disposing_on_a_topic_without_keys_or_history_does_nothing(node: Node) -> None:
    latched = node.create_publisher(String, "t", qos_profile_latched)
    latched.publish(text(1))
    latched.dispose("1")
    node.create_publisher(Lamp, "lamps").dispose("a")
    assert waiting(node.create_subscription(String, "t", qos_profile=qos_profile_latched)) == ["1"]


async def test_a_key_may_lie_in_a_nested_message(node: Node) -> None:
    slow = node.create_subscription(Wrapped, "t", qos_profile=1)
    publisher = node.create_publisher(Wrapped, "t", QoSProfile(depth=1, lifespan=10))
    for lamp in (Lamp(id="a", on=True), Lamp(id="b", on=True), Lamp(id="a", on=False)):
        publisher.publish(Wrapped(lamp=lamp))
    first = slow.take()
    assert first is not None
    assert first.lamp.id == "b"
    assert slow.lost == 1


@pytest.mark.virtual_time
async def test_an_expired_message_is_not_delivered_but_counted(node: Node) -> None:
    subscription = node.create_subscription(String, "t")
    publisher = node.create_publisher(String, "t", QoSProfile(lifespan=10))
    publisher.publish(text("old"))
    await anyio.sleep(6)
    publisher.publish(text("new"))
    await anyio.sleep(5)
    assert (await subscription.receive()).data == "new"
    assert subscription.take() is None
    assert subscription.expired == 1


@pytest.mark.virtual_time
async def test_an_expired_message_is_not_kept_for_late_joiners(node: Node) -> None:
    publisher = node.create_publisher(Lamp, "t", QoSProfile(lifespan=10, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    publisher.publish(Lamp(id="old", on=True))
    await anyio.sleep(10)
    publisher.publish(Lamp(id="new", on=True))
    late = node.create_subscription(Lamp, "t", qos_profile=LATCHED_3)
    assert (late.take(), late.take()) == (Lamp(id="new", on=True), None)


@pytest.mark.virtual_time
async def test_a_callback_is_not_called_with_an_expired_message(node: Node) -> None:
    got: list[str] = []
    gate = anyio.Event()

    async def slow(message: String) -> None:
        got.append(message.data)
        await gate.wait()

    subscription = node.create_subscription(String, "t", slow)
    publisher = node.create_publisher(String, "t", QoSProfile(lifespan=1))
    publisher.publish(text("first"))
    publisher.publish(text("second"))
    await anyio.sleep(1)
    gate.set()
    await anyio.wait_all_tasks_blocked()
    assert got == ["first"]
    assert subscription.expired == 1


@pytest.mark.parametrize("publisher_first", [True, False])
async def test_a_mismatch_is_loud_at_both_ends(run: Callable[[str], Awaitable[Node]], *, publisher_first: bool) -> None:
    talker, listener = await run("talker"), await run("listener")
    with capture_logs() as lines:
        if publisher_first:
            publisher = talker.create_publisher(String, "t", qos_profile_sensor_data)
            subscription = listener.create_subscription(String, "t")
        else:
            subscription = listener.create_subscription(String, "t")
            publisher = talker.create_publisher(String, "t", qos_profile_sensor_data)
    assert [(line["node"], line["end"], line["other_node"]) for line in lines] == [
        ("/talker", "publisher", "/listener"),
        ("/listener", "subscription", "/talker"),
    ]
    assert {(line["event"], line["log_level"], line["topic"], line["problem"]) for line in lines} == {
        ("graph.qos_incompatible", "warning", "/t", "reliability: best effort is offered, reliable is requested")
    }
    assert (publisher.incompatible_qos_count, subscription.incompatible_qos_count) == (1, 1)
    publisher.publish(text(1))
    assert waiting(subscription) == []


@pytest.mark.virtual_time
async def test_one_who_subscribes_again_and_again_cannot_flood_the_log(node: Node) -> None:
    node.create_publisher(String, "t", qos_profile_sensor_data)
    with capture_logs() as lines:
        for _ in range(5):
            node.create_subscription(String, "t").close()
        assert len(lines) == 2
        await anyio.sleep(10)
        node.create_subscription(String, "t")
    assert [line["held_back"] for line in lines] == [0, 0, 4, 4]


async def test_a_mismatch_leaves_the_other_pairs_alone(node: Node) -> None:
    publisher = node.create_publisher(String, "t", qos_profile_sensor_data)
    deaf, open_minded = (
        node.create_subscription(String, "t"),
        node.create_subscription(String, "t", qos_profile=qos_profile_sensor_data),
    )
    publisher.publish(text(1))
    assert (waiting(deaf), waiting(open_minded)) == ([], ["1"])
    assert publisher.subscription_count == 1


async def test_a_mismatch_with_a_latched_publisher_replays_nothing(node: Node) -> None:
    node.create_publisher(
        String,
        "t",
        QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.BEST_EFFORT),
    ).publish(text(1))
    assert waiting(node.create_subscription(String, "t", qos_profile=qos_profile_latched)) == []


async def test_a_second_type_on_a_topic_is_refused(run: Callable[[str], Awaitable[Node]]) -> None:
    talker, listener = await run("talker"), await run("listener")
    talker.create_publisher(String, "t")
    with pytest.raises(TypeMismatchError) as caught:
        listener.create_subscription(Bool, "/t")
    assert str(caught.value) == "/listener uses /t with std_msgs/msg/Bool, but it carries std_msgs/msg/String"
    with pytest.raises(TypeMismatchError):
        listener.create_publisher(Bool, "/t")


async def test_a_topic_nobody_uses_any_more_may_get_another_type(node: Node) -> None:
    node.create_publisher(String, "t").close()
    assert node.create_publisher(Bool, "t").info.ros_type == "std_msgs/msg/Bool"


async def test_a_message_of_another_type_is_refused_at_once(node: Node) -> None:
    publisher = node.create_publisher(String, "t", qos_profile_latched)
    with pytest.raises(TypeMismatchError) as caught:
        publisher.publish(Bool(data=True))  # type: ignore[arg-type]  # the mistake under test
    assert str(caught.value) == "/node published a Bool on /t, which carries std_msgs/msg/String"

    class Shout(String):
        pass

    with pytest.raises(TypeMismatchError, match="published a Shout"):
        publisher.publish(Shout(data="x"))


@pytest.mark.parametrize("qos", [10, qos_profile_latched])
async def test_a_closed_publisher_is_refused(node: Node, qos: int | QoSProfile) -> None:
    publisher = node.create_publisher(String, "t", qos)
    publisher.close()
    publisher.close()
    with pytest.raises(ClosedError, match="the publisher of /node on /t is closed"):
        publisher.publish(text(1))


async def test_a_closed_subscription_gets_nothing_more(node: Node) -> None:
    publisher, subscription = node.create_publisher(String, "t"), node.create_subscription(String, "t")
    publisher.publish(text(1))
    subscription.close()
    subscription.close()
    publisher.publish(text(2))
    assert [message.data async for message in subscription] == ["1"]
    with pytest.raises(ClosedError):
        await subscription.receive()


async def test_what_a_gone_publisher_left_in_the_queue_is_still_read(node: Node) -> None:
    publisher, subscription = node.create_publisher(String, "t"), node.create_subscription(String, "t")
    publisher.publish(text(1))
    publisher.close()
    assert waiting(subscription) == ["1"]


async def test_an_illegal_name_or_depth_leaves_no_topic_behind(node: Node, graph: Graph) -> None:
    before = graph.get_topic_names_and_types()
    with pytest.raises(InvalidNameError):
        node.create_publisher(String, "no good")
    with pytest.raises(QosError):
        node.create_publisher(String, "t", 0)
    with pytest.raises(QosError):
        node.create_subscription(String, "t", qos_profile=0)
    assert graph.get_topic_names_and_types() == before
