"""The look-up directory and its stream of changes."""

from collections.abc import Awaitable, Callable

import pytest

from homebot.errors import DuplicateNameError
from homebot.graph import EndpointInfo, EntityKind, Graph, GraphChange, Node, QoSProfile
from homebot.messages import Bool, String, Trigger
from homebot.messages.std_srvs import SuccessResponse


def trigger(_request: object) -> SuccessResponse:
    return SuccessResponse(success=True, message="")


async def test_it_knows_every_node(run: Callable[[str], Awaitable[Node]], graph: Graph) -> None:
    two, one = await run("two"), await run("one")
    assert graph.get_node_names() == ("/one", "/two")
    assert graph.get_node("/one") is one
    assert graph.get_node("/three") is None
    two.close()
    assert graph.get_node_names() == ("/one",)


async def test_it_knows_every_topic_and_its_type(node: Node, graph: Graph) -> None:
    publisher = node.create_publisher(Bool, "b")
    subscription = node.create_subscription(String, "~/a")
    assert graph.get_topic_names_and_types() == {
        "/b": "std_msgs/msg/Bool",
        "/node/a": "std_msgs/msg/String",
        "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    }
    assert list(graph.get_topic_names_and_types()) == ["/b", "/node/a", "/parameter_events"]
    assert graph.get_message_type("/b") is Bool
    publisher.close()
    subscription.close()
    assert graph.get_message_type("/b") is None
    assert list(graph.get_topic_names_and_types()) == ["/parameter_events"]


async def test_it_knows_every_service_that_is_served(node: Node, graph: Graph) -> None:
    client = node.create_client(Trigger, "waited_for")
    server = node.create_service(Trigger, "served", trigger)
    assert graph.get_service_names_and_types() == {"/served": "std_srvs/srv/Trigger"}
    assert graph.get_service_type("/waited_for") is Trigger
    client.close()
    server.close()
    server.close()
    assert graph.get_service_names_and_types() == {}
    assert graph.get_service_type("/waited_for") is graph.get_service_type("/served") is None


async def test_endpoints_can_be_asked_for_by_kind_name_and_node(
    run: Callable[[str], Awaitable[Node]], graph: Graph
) -> None:
    one, two = await run("one"), await run("two")
    publisher = one.create_publisher(String, "t", 3)
    subscription = two.create_subscription(String, "t")
    client, server = one.create_client(Trigger, "s"), two.create_service(Trigger, "s", trigger)
    assert graph.get_endpoints(name="/t") == (publisher.info, subscription.info)
    assert graph.get_endpoints(kind=EntityKind.SUBSCRIPTION) == (subscription.info,)
    assert graph.get_endpoints(node="/two", name="/s") == (server.info,)
    assert graph.get_endpoints(kind=EntityKind.CLIENT) == (client.info,)
    assert len(graph.get_endpoints()) == 8
    assert publisher.info == EndpointInfo(
        EntityKind.PUBLISHER, "/one", "/t", "std_msgs/msg/String", QoSProfile(depth=3)
    )
    assert (publisher.topic_name, subscription.topic_name) == ("/t", "/t")
    assert (client.service_name, server.service_name) == ("/s", "/s")


async def test_a_watcher_hears_what_comes_and_goes_in_order(graph: Graph) -> None:
    Node(graph, "before")
    with graph.watch() as changes:
        node = Node(graph, "n")
        publisher = node.create_publisher(String, "t")
        publisher.close()
        node.close()
        heard = [await changes.receive() for _ in range(6)]
        assert changes.take() is None
    assert [(change.change, change.entity.kind.value, change.entity.name) for change in heard] == [
        ("added", "node", "/n"),
        ("added", "publisher", "/parameter_events"),
        ("added", "publisher", "/t"),
        ("removed", "publisher", "/t"),
        ("removed", "publisher", "/parameter_events"),
        ("removed", "node", "/n"),
    ]
    assert heard[2] == GraphChange("added", publisher.info)


async def test_a_watcher_of_a_name_hears_only_of_that(graph: Graph) -> None:
    """Each of 300 routines waits for one service, and need not hear of all entities of the others."""
    node = Node(graph, "n")
    with graph.watch(only=(EntityKind.PUBLISHER, "/wanted")) as changes:
        node.create_publisher(String, "other")
        node.create_subscription(String, "wanted", lambda _: None)
        node.create_publisher(String, "wanted").close()
        heard = [await changes.receive() for _ in range(2)]
        assert changes.take() is None
    assert [(change.change, change.entity.name) for change in heard] == [("added", "/wanted"), ("removed", "/wanted")]


async def test_a_watch_ends_with_its_block(graph: Graph) -> None:
    with graph.watch() as changes:
        pass
    Node(graph, "n")
    assert [change async for change in changes] == []


async def test_a_watcher_that_falls_behind_loses_the_oldest_and_knows(graph: Graph) -> None:
    with graph.watch(depth=1) as changes:
        Node(graph, "n")
        assert changes.lost == 1
        assert (await changes.receive()).entity.name == "/parameter_events"


async def test_a_second_node_of_one_name_is_refused_and_disturbs_nothing(graph: Graph) -> None:
    first = Node(graph, "n")
    with pytest.raises(DuplicateNameError, match="a node /n is already running"):
        Node(graph, "n")
    assert graph.get_node("/n") is first
    first.close()
    assert Node(graph, "n").full_name == "/n"
