"""The link to ROS 2, against pyzeros and zenoh-ros2-sdk: other implementations of ROS 2 nodes on Zenoh."""

import json
import sys
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import anyio
import anyio.lowlevel
import pytest
from anyio.streams.buffered import BufferedByteReceiveStream
from tests.patience import PATIENCE
from tests.peers.ros2_house import house, robot

from homebot.graph import EntityKind, Node, qos_profile_latched
from homebot.graph.actions import ActionClient, ActionServer, GoalState, ServerGoal
from homebot.messages import Int32, String
from homebot.messages.definition import zero_message
from homebot.messages.interfaces import find_action
from homebot.messages.std_srvs import Trigger

all_msgs: Any = pytest.importorskip("ros2_pyterfaces.cyclone.all_msgs")
all_srvs: Any = pytest.importorskip("ros2_pyterfaces.cyclone.all_srvs")
T = TypeVar("T")
nav: Any = pytest.importorskip("tests.peers.navigate_to_pose")
NavigateToPose: Any = find_action("nav2_msgs/action/NavigateToPose")
HALL = NavigateToPose.Goal.model_validate(zero_message(NavigateToPose.Goal).model_dump() | {"behavior_tree": "hall"})
SDK = Path(__file__).with_name("zenoh_ros2_sdk_robot.py")


async def heard(publish: Callable[[], None], receive: Callable[[], Awaitable[T]]) -> T:
    """Return what is received; it is published until then, as a volatile message has no reader at first."""
    with anyio.fail_after(PATIENCE):
        while True:
            publish()
            with anyio.move_on_after(0.2):
                return await receive()


async def called(service: Any, name: str, **values: object) -> Any:
    """Return the response of a service of the house to pyzeros."""
    pyzeros: Any = pytest.importorskip("pyzeros")
    client = pyzeros.Client(service, name)
    with anyio.fail_after(PATIENCE):
        await client.wait_for_service()
        return await client.call_async(service.Request(**values))


@pytest.mark.newest("ros2")
async def test_topics_and_services_go_both_ways() -> None:
    pyzeros: Any = pytest.importorskip("pyzeros")

    async with house() as (app, port), robot(port) as session:
        app.create_service(Trigger, "/house/light", lambda _: Trigger.Response(success=True, message="on"))
        ours, words = app.create_publisher(String, "/house/words"), app.create_subscription(String, "/rosie/words")
        theirs, says = pyzeros.Sub(all_msgs.String, "/house/words"), pyzeros.Pub(all_msgs.String, "/rosie/words")
        switched = await called(all_srvs.Trigger, "/house/light")
        assert (switched.success, switched.message) == (True, "on")
        assert (await heard(partial(says.publish, all_msgs.String(data="hello")), words.receive)).data == "hello"
        assert (await heard(partial(ours.publish, String(data="lamp on")), theirs.wait_for_new)).data == "lamp on"
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(answers, pyzeros.Server(all_srvs.Trigger, "/rosie/dock"), docked)
            declared(session)
            client = app.create_client(Trigger, "/rosie/dock")
            assert await client.wait_for_service(PATIENCE)
            assert (await client.call(Trigger.Request(), PATIENCE)).message == "docked"
            tasks.cancel_scope.cancel()


def declared(session: Any) -> None:
    """Wait until the house knows all that *session* has declared: pyzeros shows a service before it serves it."""
    assert list(session.liveliness().get("@ros2_lv/0/**"))


async def answers(server: Any, answer: Callable[[Any], Awaitable[None]]) -> None:
    """Answer all calls of a service of pyzeros, each by itself."""
    async with anyio.create_task_group() as tasks:
        async for asked in server.listen_reliable():
            tasks.start_soon(answered, asked, answer)


async def answered(asked: Any, answer: Callable[[Any], Awaitable[None]]) -> None:
    await answer(asked)
    asked.send()


async def docked(asked: Any) -> None:
    asked.response.success, asked.response.message = True, "docked"


async def test_a_latched_map_comes_late_and_both_sides_list_nodes_and_topics() -> None:
    pyzeros: Any = pytest.importorskip("pyzeros")
    afor: Any = pytest.importorskip("asyncio_for_robotics")
    ext: Any = pytest.importorskip("zenoh.ext")

    async with house() as (app, port), robot(port) as session:
        app.create_publisher(String, "/map", qos_profile_latched).publish(String(data="rooms"))
        says, late = pyzeros.Pub(all_msgs.String, "/rosie/words"), pyzeros.Sub(all_msgs.String, "/map")
        key, got = late.raw_sub.subscriber_keyexpr, afor.BaseSub()
        history = ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
        reading = ext.declare_advanced_subscriber(session, key, got.input_data, history=history)  # as of rmw_zenoh
        with anyio.fail_after(PATIENCE):
            assert all_msgs.String.deserialize((await got.wait_for_new()).payload.to_bytes()).data == "rooms"
        await heard(
            partial(says.publish, all_msgs.String(data="x")), app.create_subscription(String, "/rosie/words").receive
        )
        nodes = {one.name for one in app.graph.get_endpoints(kind=EntityKind.NODE)}
        assert {"/rosie/brain", "/app", "/ros2"} <= nodes
        assert app.graph.get_topic_names_and_types()["/rosie/words"] == "std_msgs/msg/String"
        tokens = [str(one.ok.key_expr).split("/") for one in session.liveliness().get("@ros2_lv/0/**")]
        assert {("%", "ros2"), ("%", "app")} <= {(one[7], one[8]) for one in tokens if one[5] == "NN"}
        assert ("MP", "%map", late.raw_sub.dds_type, late.raw_sub.hash) in {
            (one[5], *one[9:12]) for one in tokens if len(one) > 11
        }
        reading.undeclare()


class Driver:
    """The house drives somewhere until it may arrive."""

    def __init__(self, app: Node) -> None:
        self.goals: list[str] = []
        self.arrived = anyio.Event()
        self.server = ActionServer(app, NavigateToPose, "/house/navigate_to_pose", self._drive)

    async def _drive(self, goal: ServerGoal[Any, Any, Any]) -> Any:
        self.goals.append(goal.request.behavior_tree)
        while not self.arrived.is_set():
            feedback = zero_message(NavigateToPose.Feedback).model_copy(update={"distance_remaining": 2.5})
            goal.publish_feedback(feedback)
            with anyio.move_on_after(0.1):
                await self.arrived.wait()
        goal.succeed()
        return NavigateToPose.Result.model_validate({"error_code": 0, "error_msg": "none"})


async def test_pyzeros_drives_an_action_of_the_house() -> None:
    pyzeros: Any = pytest.importorskip("pyzeros")
    name = "/house/navigate_to_pose/_action"

    async with house() as (app, port), robot(port):
        driver, first, second = Driver(app), nav.UUID(uuid=bytes([1]) * 16), nav.UUID(uuid=bytes([2]) * 16)
        feedback = pyzeros.Sub(nav.FeedbackMessage, f"{name}/feedback")
        for goal_id in (first, second):
            goal = nav.Goal(behavior_tree="hall")
            assert (await called(nav.SendGoal, f"{name}/send_goal", goal_id=goal_id, goal=goal)).accepted
        with anyio.fail_after(PATIENCE):
            assert (await feedback.wait_for_new()).feedback.distance_remaining == 2.5
        info = nav.GoalInfo(goal_id=second)
        cancelled = await called(nav.CancelGoal, f"{name}/cancel_goal", goal_info=info)
        assert [bytes(one.goal_id.uuid) for one in cancelled.goals_canceling] == [bytes(second.uuid)]
        assert (await called(nav.GetResult, f"{name}/get_result", goal_id=second)).status == GoalState.CANCELED
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(arrives, name, first)
            while not any(one.name == f"{name}/get_result" for one in app.graph.get_endpoints(kind=EntityKind.CLIENT)):
                await anyio.lowlevel.checkpoint()
            driver.arrived.set()
        assert driver.goals == ["hall", "hall"]


async def arrives(name: str, goal_id: Any) -> None:
    """Wait for the result, which comes when the goal ends."""
    response = await called(nav.GetResult, f"{name}/get_result", goal_id=goal_id)
    assert (response.status, response.result.error_msg) == (GoalState.SUCCEEDED, "none")


async def test_the_house_drives_an_action_of_pyzeros() -> None:
    pyzeros: Any = pytest.importorskip("pyzeros")
    name = "/rosie/navigate_to_pose/_action"
    cancelled: list[bytes] = []
    ended = {one: anyio.Event() for one in ("near", "arrived", "cancelled")}

    async def accept(asked: Any) -> None:
        assert asked.request.goal.behavior_tree == "hall"
        asked.response.accepted = True

    async def cancel(asked: Any) -> None:
        cancelled.append(bytes(asked.request.goal_info.goal_id.uuid))
        asked.response.goals_canceling = [asked.request.goal_info]
        ended["cancelled"].set()

    async def result(asked: Any) -> None:
        await ended["cancelled" if cancelled else "arrived"].wait()
        asked.response.status = GoalState.CANCELED if cancelled else GoalState.SUCCEEDED
        asked.response.result.error_msg = "none"

    async with house() as (app, port), robot(port) as session:
        said = pyzeros.Pub(nav.FeedbackMessage, f"{name}/feedback")
        async with anyio.create_task_group() as tasks:
            for service, part, answer in (
                (nav.CancelGoal, "cancel_goal", cancel),
                (nav.GetResult, "get_result", result),
                (nav.SendGoal, "send_goal", accept),
            ):
                tasks.start_soon(answers, pyzeros.Server(service, f"{name}/{part}"), answer)
            declared(session)
            client = ActionClient(app, NavigateToPose, "/rosie/navigate_to_pose")
            assert await client.wait_for_server(PATIENCE)
            assert [one.servers for one in app.graph.actions()] == [("/ros2",)]
            left: list[float] = []

            def near(feedback: Any) -> None:
                left.append(feedback.distance_remaining)
                ended["near"].set()

            goal = await client.send_goal(HALL, near)
            message = nav.FeedbackMessage(nav.UUID(uuid=goal.goal_id.uuid), nav.Feedback(distance_remaining=1.5))
            await heard(partial(said.publish, message), ended["near"].wait)
            assert left[0] == 1.5
            ended["arrived"].set()
            with anyio.fail_after(PATIENCE):
                assert (await goal.result())[0] is GoalState.SUCCEEDED
                other = await client.send_goal(HALL)
                await other.cancel()
                assert (await other.result())[0] is GoalState.CANCELED
                assert cancelled == [other.goal_id.uuid]
            tasks.cancel_scope.cancel()


async def test_pyzeros_reads_and_sets_the_parameters_of_a_node() -> None:
    pyzeros: Any = pytest.importorskip("pyzeros")

    async with house() as (app, port), robot(port):
        app.declare_parameter("speed", 3)
        events = pyzeros.Sub(all_msgs.ParameterEvent, "/parameter_events")
        assert (await called(all_srvs.ListParameters, "/app/list_parameters")).result.names == ["speed"]
        got = await called(all_srvs.GetParameters, "/app/get_parameters", names=["speed"])
        assert [one.integer_value for one in got.values] == [3]
        types = await called(all_srvs.GetParameterTypes, "/app/get_parameter_types", names=["speed"])
        assert list(types.types) == [2]
        described = await called(all_srvs.DescribeParameters, "/app/describe_parameters", names=["speed"])
        assert [one.name for one in described.descriptors] == ["speed"]
        faster = all_msgs.Parameter("speed", all_msgs.ParameterValue(type=2, integer_value=4))
        assert (await called(all_srvs.SetParameters, "/app/set_parameters", parameters=[faster])).results[0].successful
        wrong = all_msgs.Parameter("size", all_msgs.ParameterValue(type=2, integer_value=4))
        together = await called(
            all_srvs.SetParametersAtomically, "/app/set_parameters_atomically", parameters=[faster, wrong]
        )
        assert "no parameter 'size' is declared" in together.result.reason
        unset = all_msgs.Parameter("speed", all_msgs.ParameterValue(type=0))
        each = (await called(all_srvs.SetParameters, "/app/set_parameters", parameters=[unset, faster, wrong])).results
        assert [one.successful for one in each] == [False, True, False]
        assert not (await called(all_srvs.GetParameters, "/app/get_parameters", names=["speed", "size"])).values
        assert app.get_parameter("speed").value == 4
        numbers = iter(range(5, 1000))

        async def change() -> None:
            app.parameters.set_atomically({"speed": next(numbers)})

        with anyio.fail_after(PATIENCE):
            while True:
                await change()
                with anyio.move_on_after(0.2):
                    event = await events.wait_for_new()
                    break
        assert (event.node, event.changed_parameters[0].name) == ("/app", "speed")


async def test_a_robot_without_the_right_reads_parameters_and_hears_why_it_sets_none() -> None:
    faster = all_msgs.Parameter("speed", all_msgs.ParameterValue(type=2, integer_value=4))

    async with house(scope=("read", "act: all", "robot: rosie")) as (app, port), robot(port):
        app.declare_parameter("speed", 3)
        assert (await called(all_srvs.ListParameters, "/app/list_parameters")).result.names == ["speed"]
        each = await called(all_srvs.SetParameters, "/app/set_parameters", parameters=[faster, faster])
        assert [one.reason.split(";")[0] for one in each.results] == ["the right manage is missing"] * 2
        together = await called(all_srvs.SetParametersAtomically, "/app/set_parameters_atomically", parameters=[faster])
        assert together.result.reason.startswith("the right manage is missing; the token rosie has: ")
        assert app.get_parameter("speed").value == 3


async def test_zenoh_ros2_sdk_is_a_neighbour() -> None:
    pytest.importorskip("zenoh_ros2_sdk")  # it cannot log in
    async with house(is_router=False) as (app, port):
        app.create_publisher(String, "/map", qos_profile_latched).publish(String(data="rooms"))
        app.create_service(Trigger, "/house/light", lambda _: Trigger.Response(success=True, message="on"))
        app.declare_parameter("speed", 3)
        ours = app.create_publisher(Int32, "/house/number")
        words = app.create_subscription(String, "/rosie/words")
        dock = app.create_client(Trigger, "/rosie/dock")
        async with await anyio.open_process([sys.executable, str(SDK), str(port)], stderr=None) as process:
            try:
                assert process.stdout is not None
                lines = BufferedByteReceiveStream(process.stdout)
                read = partial(lines.receive_until, b"\n", 10_000)
                with anyio.fail_after(PATIENCE):
                    assert (await words.receive()).data == "hello"
                    assert await dock.wait_for_service(PATIENCE)
                    assert (await dock.call(Trigger.Request())).message == "docked"
                    facts = json.loads(await read())
                assert (facts["map"], facts["light"], facts["types"]) == ("rooms", [True, "on"], [2])
                assert {"/house/number", "/map", "/rosie/words"} <= {*facts["topics"]}
                assert {"/house/light", "/rosie/dock"} <= {*facts["services"]}
                assert await heard(partial(ours.publish, Int32(data=7)), read) == b"7"
            finally:
                process.kill()
