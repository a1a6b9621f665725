"""What the public face promises to a type checker; read by mypy, never run.

An expected error is marked ``type: ignore``, and mypy complains about each mark that is not needed.
"""

from collections.abc import Awaitable, Callable
from typing import assert_type

from homebot.clock import Clock, LoopClock, ManualClock
from homebot.graph import (
    Client,
    EndpointInfo,
    EntityKind,
    Graph,
    GraphChange,
    Node,
    Parameter,
    Publisher,
    QoSProfile,
    RosoutFeed,
    Service,
    Subscription,
    Timer,
    qos_profile_latched,
)
from homebot.messages import Bool, Message, ServiceType, SetBool, String, Trigger
from homebot.messages.json import JsonObject, message_from_json, message_to_json
from homebot.messages.std_srvs import SetBoolRequest, SetBoolResponse, SuccessResponse, TriggerRequest

clock: Clock = ManualClock()
clock = LoopClock()
graph = Graph(clock)
node = Node(graph, "name", namespace="/ns", parameters={"rate": 1.0, "names": ["a"]})
Node(graph)  # type: ignore[call-arg]  # a node has a name
Node(graph, "name", "/ns")  # type: ignore[call-arg]  # the namespace is named


async def on_text(message: String) -> None:
    assert_type(message.data, str)


def on_flag(message: Bool) -> None:
    assert_type(message.data, bool)


def publish_and_subscribe() -> None:
    publisher = node.create_publisher(String, "t")
    assert_type(publisher, Publisher[String])
    publisher.publish(String(data="x"))
    publisher.publish(Bool(data=True))  # type: ignore[arg-type]  # another type than the topic's
    publisher.publish("x")  # type: ignore[arg-type]  # no message
    String(data=1)  # type: ignore[arg-type]  # a field of another type
    String()  # type: ignore[call-arg]  # a field is missing
    String(data="x").data = "y"  # type: ignore[misc]  # messages are frozen

    assert_type(node.create_subscription(String, "t"), Subscription[String])
    assert_type(node.create_subscription(String, "t", on_text, 10), Subscription[String])
    node.create_subscription(Bool, "t", on_flag, qos_profile_latched, concurrent=True)
    node.create_subscription(String, "t", on_flag)  # type: ignore[arg-type]  # the callback takes another type
    node.create_publisher(str, "t")  # type: ignore[type-var]  # no message type
    node.create_publisher(String, "t", "10")  # type: ignore[arg-type]  # neither a depth nor a profile
    assert_type(publisher.qos, QoSProfile)
    assert_type(publisher.info, EndpointInfo)


async def read(subscription: Subscription[String]) -> None:
    async for message in subscription:
        assert_type(message, String)
    assert_type(await subscription.receive(), String)
    assert_type(subscription.take(), String | None)
    assert_type(subscription.lost, int)


async def send(publisher: Publisher[String]) -> None:
    await publisher.send(String(data="x"))
    await publisher.send(Bool(data=True))  # type: ignore[arg-type]  # another type than the topic's


def switch(request: SetBoolRequest) -> SetBoolResponse:
    return SetBoolResponse(success=request.data, message="")


async def switch_later(request: SetBoolRequest) -> SetBoolResponse:
    return switch(request)


async def serve_and_call() -> None:
    assert_type(SetBool, ServiceType[SetBoolRequest, SetBoolResponse])
    assert_type(node.create_service(SetBool, "s", switch), Service[SetBoolRequest, SetBoolResponse])
    node.create_service(SetBool, "s", switch_later, concurrent=True)
    node.create_service(Trigger, "s", switch)  # type: ignore[arg-type]  # the handler is of another service
    client = node.create_client(SetBool, "s")
    assert_type(client, Client[SetBoolRequest, SetBoolResponse])
    response = await client.call(SetBool.Request(data=True), timeout=1)
    assert_type(response, SetBoolResponse)
    await client.call(TriggerRequest())  # type: ignore[arg-type]  # the request of another service
    assert_type(await node.create_client(Trigger, "t").call(Trigger.Request()), SuccessResponse)
    assert_type(await client.wait_for_service(timeout=1.0), bool)


def rest() -> None:
    callback: Callable[[], Awaitable[None]] = node.__aenter__  # type: ignore[assignment]  # a timer's is not a node's
    assert_type(node.create_timer(0.5, callback), Timer)
    assert_type(node.declare_parameter("rate", 1.0), Parameter)
    node.declare_parameter("nested", {"a": 1})  # type: ignore[arg-type]  # a parameter is flat
    assert_type(graph.get_endpoints(kind=EntityKind.NODE), tuple[EndpointInfo, ...])
    assert_type(graph.get_message_type("/t"), type[Message] | None)
    RosoutFeed(node)


async def watch() -> None:
    with graph.watch() as changes:
        async for change in changes:
            assert_type(change, GraphChange)


def convert() -> None:
    assert_type(message_to_json(String(data="x")), JsonObject)
    assert_type(message_from_json(String, {"data": "x"}), String)
