"""A robot behind zenoh-bridge-ros2dds: a session of Zenoh alone, with the tokens, keys and bytes of the bridge."""

import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from typing import Any

import anyio
import anyio.lowlevel
import pytest
import zenoh
from anyio import to_thread
from tests.features.ros2.pair import access, appears, linked
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import log_in

from homebot.devices.health import GetHealth, HealthRequest
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.graph.actions import ActionClient, GoalState
from homebot.messages import String
from homebot.messages.action_msgs import CancelGoal
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import PoseWithCovarianceStamped
from homebot.messages.interfaces import find_action, find_message
from homebot.messages.interfaces.settings import RosSettings
from homebot.messages.message import Message
from homebot.messages.std_srvs import Trigger

rosbags: Any = pytest.importorskip("rosbags.typesys")
STORE = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
BATTERY: Any = find_message("sensor_msgs/msg/BatteryState")
NAVIGATE: Any = find_action("nav2_msgs/action/NavigateToPose")


class Bridge:
    """The session of the bridge of a robot."""

    def __init__(self, session: zenoh.Session) -> None:
        self.session, self.attachments = session, list[object]()
        self._kept: list[Any] = []

    def announce(self, *parts: str) -> None:
        text = "/".join(("@", str(self.session.zid()), "@ros2_lv", *parts))
        self._kept.append(self.session.liveliness().declare_token(text))

    def serve(self, key: str, answer: Callable[[bytes], bytes], reply_key: str = "") -> None:
        """Answer as the bridge does: its services are not complete, and it takes no attachment but its own."""

        def asked(query: zenoh.Query) -> None:
            with query:
                self.attachments.append(query.attachment)
                query.reply(reply_key or key, answer(b"" if query.payload is None else bytes(query.payload)))

        self._kept.append(self.session.declare_queryable(key, asked))

    def leave(self) -> None:
        for one in self._kept:
            one.undeclare()


def battery(percentage: float) -> bytes:
    """Return the bytes of a BatteryState as another library writes them."""
    names = STORE.types
    stamp = names["builtin_interfaces/msg/Time"](sec=1, nanosec=2)
    nothing = rosbags_array(0)
    message = names["sensor_msgs/msg/BatteryState"](
        header=names["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link"),
        voltage=24.0,
        temperature=20.0,
        current=-1.0,
        charge=1.0,
        capacity=2.0,
        design_capacity=2.0,
        percentage=percentage,
        power_supply_status=2,
        power_supply_health=1,
        power_supply_technology=2,
        present=True,
        cell_voltage=nothing,
        cell_temperature=nothing,
        location="bay",
        serial_number="7",
    )
    return bytes(STORE.serialize_cdr(message, "sensor_msgs/msg/BatteryState"))


def rosbags_array(size: int) -> Any:
    numpy: Any = pytest.importorskip("numpy")
    return numpy.zeros(size, dtype="float32")


@asynccontextmanager
async def bridged(*names: str) -> AsyncIterator[tuple[Node, list[Bridge]]]:
    """Yield an app of a house that imports what is below the name of each robot, and the bridges of *names*."""
    address = f"tcp/127.0.0.1:{reserve_port()}"
    house = RosSettings.model_validate(
        {"listen": address, "import": {"rosie": ("/rosie/**",), "bob": ("/bob/**",)}, "export": ("/house/**",)}
    )
    robots = RobotsOnWire(house.imports, {name: access(name) for name in house.imports})
    async with anyio.create_task_group() as tasks, Node(Graph(), "app") as app:
        await tasks.start(partial(linked, app.graph, "ros2", "/", house, robots))
        sessions = [await to_thread.run_sync(partial(log_in, address, name, patience=PATIENCE)) for name in names]
        try:
            yield app, [Bridge(session) for session in sessions]
        finally:
            for session in sessions:
                await to_thread.run_sync(session.close)
            tasks.cancel_scope.cancel()


async def heard(app: Node, topic: str, message_type: type[Message], say: Callable[[], None]) -> Message:
    """Return what comes on *topic*; it is said until then, as there is no reader at first."""
    reader = app.create_subscription(message_type, topic)
    with anyio.fail_after(PATIENCE):
        while True:
            say()
            with anyio.move_on_after(0.1):
                return await reader.receive()


async def test_a_topic_behind_the_bridge_is_one_of_the_graph_while_its_token_is_there() -> None:
    async with bridged("rosie") as (app, [rosie]):
        rosie.announce("MP", "rosie§battery_state", "sensor_msgs§msg§BatteryState", ":1:0:0,10")
        await appears(app.graph, "/rosie/battery_state")
        put = partial(rosie.session.put, "rosie/battery_state", battery(0.75))
        message: Any = await heard(app, "/rosie/battery_state", BATTERY, put)
        assert (message.percentage, message.location) == (0.75, "bay")
        rosie.leave()
        with anyio.fail_after(PATIENCE):
            while any(one.node == "/ros2" for one in app.graph.get_endpoints(name="/rosie/battery_state")):
                await anyio.lowlevel.checkpoint()


async def test_the_last_pose_of_a_robot_that_stands_still_comes_from_the_cache_of_its_bridge() -> None:
    pose = zero_message(PoseWithCovarianceStamped)
    async with bridged("rosie") as (app, [rosie]):
        cache = f"@/{rosie.session.zid()}/@ros2_pub_cache/rosie/amcl_pose"
        rosie.serve(cache, lambda _: message_to_cdr(pose), "rosie/amcl_pose")
        rosie.announce("MP", "rosie§amcl_pose", "geometry_msgs§msg§PoseWithCovarianceStamped", ":1:1:0,1")
        await appears(app.graph, "/rosie/amcl_pose")
        reader = app.create_subscription(PoseWithCovarianceStamped, "/rosie/amcl_pose", qos_profile=qos_profile_latched)
        with anyio.fail_after(PATIENCE):
            assert await reader.receive() == pose


async def test_a_service_behind_the_bridge_answers_and_is_sent_no_attachment() -> None:
    async with bridged("rosie") as (app, [rosie]):
        docked = message_to_cdr(Trigger.Response(success=True, message="docked"))
        rosie.serve("rosie/dock", lambda _: docked)
        rosie.announce("SS", "rosie§dock", "std_srvs§srv§Trigger")
        await appears(app.graph, "/rosie/dock")
        with anyio.fail_after(PATIENCE):
            answer = await app.create_client(Trigger, "/rosie/dock").call(Trigger.Request(), PATIENCE)
        assert answer.message == "docked"
        assert set(rosie.attachments) == {None}


_ACTION = "rosie/navigate_to_pose/_action"


class Drive:
    """The action of a robot, which takes each goal; it is done at once, or once it is cancelled."""

    def __init__(self, rosie: Bridge, *, lasts: bool) -> None:
        self.goals, self.cancelled = list[Any](), list[Any]()
        self._rosie, self._ends = rosie, threading.Event()
        if not lasts:
            self._ends.set()

    async def offer(self, graph: Graph) -> None:
        self._rosie.serve(f"{_ACTION}/send_goal", self._take)
        self._rosie.serve(f"{_ACTION}/get_result", self._finish)
        self._rosie.serve(f"{_ACTION}/cancel_goal", self._cancel)
        self._rosie.announce("AS", "rosie§navigate_to_pose", "nav2_msgs§action§NavigateToPose")
        for part in ("send_goal", "cancel_goal", "get_result", "feedback", "status"):
            await appears(graph, f"/{_ACTION}/{part}")

    def _take(self, payload: bytes) -> bytes:
        self.goals.append(message_from_cdr(NAVIGATE.SendGoal.Request, payload))
        return message_to_cdr(zero_message(NAVIGATE.SendGoal.Response).model_copy(update={"accepted": True}))

    def _finish(self, _payload: bytes) -> bytes:
        feedback = zero_message(NAVIGATE.Feedback).model_copy(update={"distance_remaining": 1.5})
        told = NAVIGATE.FeedbackMessage(goal_id=self.goals[0].goal_id, feedback=feedback)
        self._rosie.session.put(f"{_ACTION}/feedback", message_to_cdr(told))
        self._ends.wait(PATIENCE)
        status = 5 if self.cancelled else 4
        return message_to_cdr(NAVIGATE.GetResult.Response(status=status, result=zero_message(NAVIGATE.Result)))

    def _cancel(self, payload: bytes) -> bytes:
        request: Any = message_from_cdr(CancelGoal.Request, payload)
        self.cancelled.append(request.goal_info.goal_id)
        self._ends.set()
        answer = {"return_code": 0, "goals_canceling": (request.goal_info,)}
        return message_to_cdr(zero_message(CancelGoal.Response).model_copy(update=answer))


async def test_a_robot_behind_the_bridge_navigates() -> None:
    async with bridged("rosie") as (app, [rosie]):
        drive = Drive(rosie, lasts=False)
        await drive.offer(app.graph)
        left: list[float] = []
        with anyio.fail_after(PATIENCE):
            client = ActionClient(app, NAVIGATE, "/rosie/navigate_to_pose")
            goal = await client.send_goal(
                zero_message(NAVIGATE.Goal).model_copy(update={"behavior_tree": "hall"}),
                lambda feedback: left.append(feedback.distance_remaining),
            )
            state, _ = await goal.result()
            while not left:
                await anyio.lowlevel.checkpoint()
        assert state is GoalState.SUCCEEDED
        assert left == [1.5]
        assert [one.goal.behavior_tree for one in drive.goals] == ["hall"]


async def test_a_goal_of_a_robot_behind_the_bridge_is_cancelled() -> None:
    async with bridged("rosie") as (app, [rosie]):
        drive = Drive(rosie, lasts=True)
        await drive.offer(app.graph)
        with anyio.fail_after(PATIENCE):
            goal = await ActionClient(app, NAVIGATE, "/rosie/navigate_to_pose").send_goal(zero_message(NAVIGATE.Goal))
            answer = await goal.cancel()
            state, _ = await goal.result()
        assert state is GoalState.CANCELED
        assert [one.goal_id for one in answer.goals_canceling] == drive.cancelled == [drive.goals[0].goal_id]


async def test_a_robot_has_no_topic_of_another_and_says_nothing_on_it() -> None:
    async with bridged("rosie", "bob") as (app, [rosie, bob]):
        bob.announce("MP", "rosie§words", "std_msgs§msg§String", ":1:0:0,10")
        bob.announce("AS", "rosie§navigate_to_pose", "nav2_msgs§action§NavigateToPose")
        bob.announce("MP", "house§words", "std_msgs§msg§String", ":1:0:0,10")
        bob.announce("MP", "bob§words", "std_msgs§msg§String", ":1:0:0,10")
        await appears(app.graph, "/bob/words")  # what came before it has come by now
        assert not app.graph.get_endpoints(name="/rosie/words")
        assert not app.graph.get_endpoints(name="/house/words")
        assert not app.graph.get_endpoints(name="/rosie/navigate_to_pose/_action/send_goal")
        rosie.announce("MP", "rosie§words", "std_msgs§msg§String", ":1:0:0,10")
        await appears(app.graph, "/rosie/words")
        both = app.create_subscription(String, "/rosie/words")
        own = app.create_subscription(String, "/bob/words")
        words: list[str] = []
        with anyio.fail_after(PATIENCE):
            while own.take() is None:
                bob.session.put("rosie/words", message_to_cdr(String(data="bob")))
                bob.session.put("bob/words", message_to_cdr(String(data="bob")))
                with anyio.move_on_after(0.05):
                    await own.mailbox.wait()
            while "rosie" not in words:
                rosie.session.put("rosie/words", message_to_cdr(String(data="rosie")))
                with anyio.move_on_after(0.05):
                    await both.mailbox.wait()
                words += [message.data for message in iter(both.take, None)]
        assert set(words) == {"rosie"}


async def test_another_definition_and_an_unknown_type_are_troubles() -> None:
    async with bridged("rosie") as (app, [rosie]):
        other = f":1:0:0,10:typehash=RIHS01_{'0' * 64};"
        rosie.announce("MP", "rosie§words", "std_msgs§msg§String", other)
        rosie.announce("MP", "rosie§odd", "acme_msgs§msg§Odd", ":1:0:0,10")
        health = app.create_client(GetHealth, "/ros2/health")
        with anyio.fail_after(PATIENCE):
            while len(troubles := (await health.call(HealthRequest(), PATIENCE)).troubles) != 2:
                await anyio.lowlevel.checkpoint()
        assert "acme_msgs/msg/Odd" in " ".join(troubles)
        assert "/rosie/words of /rosie/zenoh_bridge_ros2dds has another std_msgs/msg/String" in " ".join(troubles)
