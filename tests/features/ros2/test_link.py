"""The link: topics and services of a house and of a robot."""

import time
from collections.abc import Mapping, Sequence
from itertools import pairwise

import anyio
import anyio.lowlevel
import pytest
from structlog.testing import capture_logs
from tests.features.ros2.pair import appears, pair
from tests.patience import PATIENCE

from homebot.errors import ServiceUnavailableError
from homebot.graph import EntityKind, Graph, Node, Subscription, qos_profile_latched
from homebot.graph.parameters import Parameter
from homebot.messages import String
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.interfaces import Interfaces, find_service
from homebot.messages.message import Message
from homebot.messages.std_srvs import SuccessResponse, Trigger
from homebot.messages.type_hash import type_hash


async def received(subscription: Subscription[String]) -> str:
    with anyio.fail_after(PATIENCE):
        return (await subscription.receive()).data


async def told(lines: Sequence[Mapping[str, object]], count: int) -> None:
    """Wait until the log says of *count* things that they are not imported."""
    with anyio.fail_after(PATIENCE):
        while sum(line["event"] == "ros2.not_imported" for line in lines) < count:
            await anyio.lowlevel.checkpoint()


async def leaves(graph: Graph, service: str) -> None:
    """Wait until *service* has no server in *graph*."""
    with graph.watch() as changes, anyio.fail_after(PATIENCE):
        while service in graph.get_service_names_and_types():
            await changes.receive()


async def test_a_latched_message_of_the_house_comes_to_a_robot_that_joins_later() -> None:
    async with pair() as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        app.create_publisher(String, "/house/map", qos_profile_latched).publish(String(data="rooms"))
        late = nav.create_subscription(String, "/house/map", qos_profile=qos_profile_latched)
        assert await received(late) == "rooms"


async def test_what_a_robot_publishes_comes_to_the_house_and_stays_where_it_is_not_exported() -> None:
    async with pair("read", "robot: rosie") as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        words = app.create_subscription(String, "/rosie/words", qos_profile=qos_profile_latched)
        nav.create_publisher(String, "/secret", qos_profile_latched).publish(String(data="no"))
        nav.create_publisher(String, "/rosie/words", qos_profile_latched).publish(String(data="hello"))
        assert await received(words) == "hello"
        assert "/secret" not in both.house.get_topic_names_and_types()
        assert {one.node for one in both.house.get_endpoints(name="/rosie/words")} == {"/app", "/ros2"}


async def test_calls_of_a_robot_leave_others_as_long_as_they_take() -> None:
    """A hundred queries for all devices of a large house came one directly after the other."""
    busy: list[tuple[float, float]] = []

    def work(_: Message) -> SuccessResponse:
        began = time.monotonic()
        while time.monotonic() < began + 0.01:
            pass
        busy.append((began, time.monotonic()))
        return SuccessResponse(success=True, message="")

    async with pair() as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        app.create_service(Trigger, "/house/work", work)
        client = nav.create_client(Trigger, "/house/work")
        assert await client.wait_for_service(PATIENCE)
        async with anyio.create_task_group() as tasks:
            for _ in range(10):
                tasks.start_soon(client.call, Trigger.Request(), PATIENCE)
    gaps = [began - ended for (_, ended), (began, _) in pairwise(busy)]
    assert len(busy) == 10
    assert min(gaps) > 0.009


async def test_what_is_of_a_robot_does_not_come_without_the_right_to_be_it() -> None:
    with capture_logs() as lines:
        async with pair("read", "act: all") as both, Node(both.robot, "nav") as nav:
            nav.create_publisher(PoseStamped, "/rosie/pose")
            nav.create_service(Trigger, "/rosie/dock", lambda _: Trigger.Response(success=True, message=""))
            nav.create_publisher(String, "/free/words")
            await told(lines, 2)
            await appears(both.house, "/free/words")
            assert not both.house.get_endpoints(name="/rosie/pose")
            assert "/rosie/dock" not in both.house.get_service_names_and_types()
    assert all("the right robot is missing" in one["problem"] for one in lines if one["event"] == "ros2.not_imported")


async def test_a_service_of_a_robot_answers_and_is_unavailable_at_once_when_it_left() -> None:
    async with pair("read", "robot: rosie") as both, Node(both.house, "app") as app:
        async with Node(both.robot, "nav") as nav:
            nav.create_service(Trigger, "/rosie/dock", lambda _: Trigger.Response(success=True, message="docked"))
            await appears(both.house, "/rosie/dock")
            client = app.create_client(Trigger, "/rosie/dock")
            assert (await client.call(Trigger.Request(), PATIENCE)).message == "docked"
        await leaves(both.house, "/rosie/dock")
        with pytest.raises(ServiceUnavailableError):
            await client.call(Trigger.Request(), PATIENCE)


@pytest.mark.parametrize(
    ("scope", "answer"),
    [(("read", "act: all"), "on"), (("read",), "the right act is missing; the token rosie has: read.")],
)
async def test_a_robot_calls_a_service_of_the_house_only_with_the_right(scope: tuple[str, ...], answer: str) -> None:
    async with pair(*scope) as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        app.create_service(Trigger, "/house/light", lambda _: Trigger.Response(success=True, message="on"))
        await appears(both.robot, "/house/light")
        response = await nav.create_client(Trigger, "/house/light").call(Trigger.Request(), PATIENCE)
        assert response.success == (answer == "on")
        assert response.message.startswith(answer)


async def test_a_robot_without_the_right_hears_of_each_parameter_why_it_is_not_set() -> None:
    set_parameters = find_service("rcl_interfaces/srv/SetParameters")
    async with pair("read", export="/app/*") as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        app.declare_parameter("speed", 3)
        await appears(both.robot, "/app/set_parameters")
        request = set_parameters.Request(parameters=tuple(Parameter("speed", one).to_message() for one in (4, 5)))
        response = await nav.create_client(set_parameters, "/app/set_parameters").call(request, PATIENCE)
        assert [one.reason.split(";")[0] for one in response.results] == ["the right manage is missing"] * 2
        assert app.get_parameter("speed").value == 3


async def test_the_nodes_of_a_robot_are_nodes_of_the_graph_while_the_link_is_there() -> None:
    async with pair() as both:
        await appears(both.house, "/rosie/brain")
        assert [one.name for one in both.house.get_endpoints(kind=EntityKind.NODE)] == ["/ros2", "/rosie/brain"]
        async with Node(both.robot, "nav") as nav:
            nav.create_publisher(String, "/rosie/words")
            await appears(both.house, "/rosie/words")
            there = {(one.kind, one.name) for one in both.house.elsewhere.find(None, None, "/rosie/brain")}
            assert {(EntityKind.NODE, "/rosie/brain"), (EntityKind.PUBLISHER, "/rosie/words")} <= there
    assert both.house.get_endpoints() == ()
    assert both.house.elsewhere.find(None, None, None) == ()


async def test_a_type_that_differs_is_refused_with_both_hashes() -> None:
    here, there = own_type("int64 a"), own_type("int32 a")
    with capture_logs() as lines:
        async with pair() as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
            nav.create_subscription(here, "/house/state")
            app.create_publisher(there, "/house/state")
            await told(lines, 1)
            assert [one.node for one in both.robot.get_endpoints(name="/house/state")] == ["/nav"]
    (problem,) = [line["problem"] for line in lines if line["event"] == "ros2.not_imported"]
    assert f"its hash is {type_hash(there)}, here {type_hash(here)}" in problem


def own_type(text: str) -> type[Message]:
    interfaces = Interfaces()
    interfaces.define("my_msgs/msg/State", text)
    return interfaces.find_message("my_msgs/State")
