"""A robot's client that dies: its goals, its pose and its leases end, each within its limit; in virtual time."""

import json

import anyio
import anyio.lowlevel
import pytest
from anyio.abc import TaskGroup
from tests.bridges.fibonacci import server
from tests.control.conftest import Home, OpenHome
from tests.robots.test_tracker import HOUSE

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.client import OutsideClient
from homebot.bridges.rosbridge.session import ClientSession, SessionLink
from homebot.bridges.rosbridge.settings import RosbridgeSettings
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.devices.names import HOLD_PART, WHERE_IS_ROBOT
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.devices.robot_owners import RobotOwners
from homebot.errors import LinkError
from homebot.graph import Node
from homebot.robots.tracker import RobotTracker
from homebot.words.rights import read_scope

pytestmark = pytest.mark.virtual_time

OWNERS = RobotOwners({"rosie": ()})
TICK = 0.01
"""Seconds for the calls that end the goal and the lease; a ping is sent every 0.4 s, and answered within 2.6 s."""

SCOPE = ["read", "act: all", "robot: rosie"]


class Client:
    """The program of the robot rosie at the door, without a socket."""

    def __init__(self, door: Node) -> None:
        self.shared = SharedState(door, RosbridgeSettings(), lambda: OWNERS)
        self._frames, self._received = anyio.create_memory_object_stream[str](100)
        self._is_there = True
        self._is_cut = anyio.Event()
        link = SessionLink(self._send, self._is_cut.set, self._ping, bool)
        client = OutsideClient(self.shared, ClientAccess("rosie", read_scope(SCOPE), OWNERS), "rosie")
        self._session = ClientSession(client, link, is_roslibpy=False)

    async def serve(self) -> None:
        """Serve it until its connection ends."""
        with self._frames, self._received:
            await self._session.run(self._received)

    async def say(self, op: str, **fields: object) -> None:
        await self._frames.send(json.dumps({"op": op, **fields}))

    def close(self) -> None:
        """Kill the program: its connection closes."""
        self._frames.close()

    def vanish(self) -> None:
        """Take its radio away: nothing closes, and nothing answers."""
        self._is_there = False

    async def _send(self, _frame: str | bytes) -> None:
        if self._is_cut.is_set():
            raise LinkError("the client is gone")

    async def _ping(self) -> None:
        if not self._is_there:
            await anyio.sleep_forever()


async def act(home: Home, tasks: TaskGroup, door: Node) -> Client:
    """Let rosie state its pose, send a goal, and hold a lock."""
    client = Client(door)
    tasks.start_soon(client.serve)
    header = {"frame_id": "map", "stamp": {"sec": 0, "nanosec": 0}}
    pose = {"position": {"x": 1.0, "y": 1.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    await client.say("advertise", topic="/rosie/pose", type="geometry_msgs/PoseStamped")
    await client.say("publish", topic="/rosie/pose", msg={"header": header, "pose": pose})
    goal = {"action": "/fib", "action_type": "example_interfaces/action/Fibonacci", "args": {"order": 50}}
    await client.say("send_action_goal", id="g", **goal)
    device = (await home.devices.find("closure"))[0].id
    setting = {"capability": "movement", "value": "open"}
    held = {"device": device, "setting": setting, "lease": "1", "by": "rosie", "ttl": 60, "issuer": ""}
    await client.say("call_service", service=HOLD_PART, args=held)
    return client


@pytest.mark.parametrize("death", ["close", "vanish"])
async def test_goals_pose_and_leases_of_a_robot_that_dies_end_within_their_limits(
    open_home: OpenHome, death: str
) -> None:
    async with (
        open_home(always_ask=False) as home,
        server(home.graph) as fib,
        Node(home.graph, "rosbridge_websocket") as door,
        Node(home.graph, "robots") as robots,
        anyio.create_task_group() as tasks,
    ):
        await tasks.start(RobotTracker(robots, OWNERS, lambda: HOUSE).serve)
        home.put("door", "closure", "movement", "position")
        await home.report("door", "movement", "closed")
        await anyio.sleep(1)
        client = await act(home, tasks, door)
        where = home.app.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        await anyio.sleep(1)
        assert (len(fib.goals), len(await home.leases())) == (1, 1)
        assert (await where.call(WhereIsRobotRequest(robot="rosie"))).pose[0].room == "Hall"
        began = anyio.current_time()
        getattr(client, death)()
        await anyio.sleep(1 if death == "close" else 3 + TICK)
        assert (len(fib.goals), await home.leases()) == (0, ())
        await anyio.sleep_until(began + 4.5)  # it told its pose a second before
        assert "pose is 5 s old (limit 5 s)" in (await where.call(WhereIsRobotRequest(robot="rosie"))).message
        tasks.cancel_scope.cancel()
