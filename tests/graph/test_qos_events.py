"""Events of quality of service: a robot that falls silent is noticed, in virtual time."""

from collections.abc import Awaitable, Callable
from typing import TypeVar

import anyio
import anyio.lowlevel
import pytest

from homebot.graph import Graph, LivelinessPolicy, Node, QoSProfile
from homebot.graph.qos_events import (
    LivelinessChangedStatus,
    LivelinessLostStatus,
    MatchedStatus,
    OfferedDeadlineMissedStatus,
    RequestedDeadlineMissedStatus,
)
from homebot.messages import String

pytestmark = pytest.mark.virtual_time

T = TypeVar("T")
DEADLINE = QoSProfile(deadline=2.0)
MANUAL = QoSProfile(liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=1.0)
HELLO = String(data="hello")


@pytest.fixture
async def other(run: Callable[[str], Awaitable[Node]]) -> Node:
    return await run("other")


async def test_both_ends_count_their_matches(node: Node, other: Node) -> None:
    publisher, subscription = node.create_publisher(String, "a"), other.create_subscription(String, "a")
    publishing: list[MatchedStatus] = []
    subscribing: list[MatchedStatus] = []
    publisher.on_event(MatchedStatus, publishing.append)
    subscription.on_event(MatchedStatus, subscribing.append)
    await anyio.lowlevel.checkpoint()
    assert publishing == subscribing == [MatchedStatus(1, 1, 1, 1)]
    second = node.create_publisher(String, "a")
    await anyio.lowlevel.checkpoint()
    assert subscribing[-1] == MatchedStatus(2, 1, 2, 1)
    second.close()
    publisher.close()
    await anyio.lowlevel.checkpoint()
    assert subscribing[-1] == MatchedStatus(2, 0, 0, -2)
    assert len(publishing) == 1


async def test_ends_that_do_not_match_count_nothing(node: Node, other: Node) -> None:
    statuses: list[MatchedStatus] = []
    other.create_subscription(String, "a", None, DEADLINE).on_event(MatchedStatus, statuses.append)
    node.create_publisher(String, "a")
    await anyio.lowlevel.checkpoint()
    assert statuses == []


async def test_a_missed_deadline_is_counted_at_both_ends_for_each_period(node: Node, other: Node) -> None:
    offered: list[OfferedDeadlineMissedStatus] = []
    requested: list[RequestedDeadlineMissedStatus] = []
    publisher = node.create_publisher(String, "a", DEADLINE)
    subscription = other.create_subscription(String, "a", None, DEADLINE)
    publisher.on_event(OfferedDeadlineMissedStatus, offered.append)
    subscription.on_event(RequestedDeadlineMissedStatus, requested.append)
    await anyio.sleep(10.0)
    assert (offered, requested) == ([], [])
    for _ in range(5):
        publisher.publish(HELLO)
        await anyio.sleep(1.5)
    assert (offered, requested) == ([], [])
    await anyio.sleep(3.0)
    assert offered == [OfferedDeadlineMissedStatus(1, 1), OfferedDeadlineMissedStatus(2, 1)]
    publisher.close()
    await anyio.sleep(2.0)
    assert len(offered) == 2
    assert requested[-1] == RequestedDeadlineMissedStatus(3, 1)
    subscription.close()
    await anyio.sleep(10.0)
    assert len(requested) == 3


async def test_a_lease_that_ends_is_lost_and_an_assertion_regains_it(node: Node, other: Node) -> None:
    lost: list[LivelinessLostStatus] = []
    changed: list[LivelinessChangedStatus] = []
    publisher = node.create_publisher(String, "a", MANUAL)
    publisher.on_event(LivelinessLostStatus, lost.append)
    other.create_subscription(String, "a", None, MANUAL).on_event(LivelinessChangedStatus, changed.append)
    await anyio.sleep(5.0)
    assert (lost, changed) == ([], [])
    for _ in range(3):
        publisher.publish(HELLO)
        await anyio.sleep(0.8)
        publisher.assert_liveliness()
        await anyio.sleep(0.8)
    assert (lost, changed) == ([], [LivelinessChangedStatus(1, 0, 1, 0)])
    await anyio.sleep(5.0)
    assert lost == [LivelinessLostStatus(1, 1)]
    assert changed[-1] == LivelinessChangedStatus(0, 1, -1, 1)
    publisher.assert_liveliness()
    await anyio.sleep(0.5)
    assert changed[-1] == LivelinessChangedStatus(1, 0, 1, -1)
    publisher.close()
    await anyio.sleep(5.0)
    assert changed[-1] == LivelinessChangedStatus(0, 0, -1, 0)
    assert len(lost) == 1


async def test_an_automatic_publisher_is_alive_while_it_exists(graph: Graph, other: Node) -> None:
    changed: list[LivelinessChangedStatus] = []
    other.create_subscription(String, "a").on_event(LivelinessChangedStatus, changed.append)
    async with Node(graph, "robot") as robot:
        robot.create_publisher(String, "a")
        await anyio.sleep(100.0)
    await anyio.lowlevel.checkpoint()
    assert changed == [LivelinessChangedStatus(1, 0, 1, 0), LivelinessChangedStatus(0, 0, -1, 0)]


async def test_a_failing_callback_is_counted_and_costs_only_its_event(node: Node, other: Node, graph: Graph) -> None:
    def fail(_status: MatchedStatus) -> None:
        raise ValueError("no")

    node.create_publisher(String, "a").on_event(MatchedStatus, fail)
    other.create_subscription(String, "a")
    await anyio.lowlevel.checkpoint()
    assert [(one.callback, one.count) for one in graph.failures] == [("event handler of /a", 1)]
