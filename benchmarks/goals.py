"""The processor time of a plan for a goal in a house of 50 rooms and 500 lamps, with a robot and closed doors."""

from __future__ import annotations

import asyncio
import time

from anyio.lowlevel import checkpoint

from directory import sighting
from homebot.clock import LoopClock
from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report as DeviceReport
from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.part import Capability, Part
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex, Directory, DirectorySettings
from homebot.discovery.owner_facts import OwnerFacts
from homebot.features.goals import ACHIEVE_WORDS
from homebot.features.goals.achieve_server import AchieveServer
from homebot.features.goals.messages import AchieveRequest, AchieveWords
from homebot.graph import Graph, Node
from homebot.graph.actions import ActionServer
from homebot.messages import Time
from homebot.messages.interfaces import find_action
from homebot.places import HouseDoor, HouseRoom, Places
from plan import Plan
from report import Report, milliseconds, verdict
from rounds import median

__all__ = ["run"]

ROOMS = 50
LAMPS = 500
SIDE = 4.0
MOTOR = 3
"""Of so many doors one is closed, and has a motor."""

AIM = 1.0
TIMES = 5
HEADINGS = ("goal", "steps", "first", "median", "aim", "")
GOALS = {
    "Room 0 lit": True,
    "Room 7 lit and robi in Room 7": True,
    "robi in Room 49 and Room 3 lit": True,
    "lights on": True,
    "lights on and lights off": False,
}
"""Whether there is a plan."""


def run(plan: Plan) -> Report:
    rows: list[tuple[str, ...]] = [HEADINGS, *asyncio.run(_rows(plan.rounds(TIMES)))]
    return Report(f"Goals: milliseconds of the processor for a plan; {ROOMS} rooms, {LAMPS} lamps", (), (), rows)


async def _rows(times: int) -> list[tuple[str, ...]]:
    graph = Graph(LoopClock(0.0))
    async with Node(graph, "discovery") as node, Node(graph, "robi") as robot, Node(graph, "goals") as goals:
        directory = Directory(node, DirectorySettings(persist=False), owner=OwnerFacts("Home", _places()))
        _announce_all(directory.index, graph.clock.monotonic())
        node.create_task(directory.serve)
        robot.create_service(WhereIsRobot, WHERE_IS_ROBOT, _where)
        navigate = find_action("nav2_msgs/action/NavigateToPose")
        ActionServer(robot, navigate, "/robi/navigate_to_pose", _drive)
        AchieveServer(goals, "", lambda: None, {}, checkpoint).serve(ACHIEVE_WORDS.name)
        client = robot.create_client(AchieveWords, ACHIEVE_WORDS.name)
        rows: list[tuple[str, ...]] = []
        for goal, has_plan in GOALS.items():
            spent, answers = [], []
            for _ in range(times + 1):
                began = time.process_time()
                answers.append(await client.call(AchieveRequest(goal=goal, is_dry_run=True), timeout=60))
                spent.append(time.process_time() - began)
            answer = answers[-1]
            if answer.success is not has_plan:
                raise RuntimeError(f"{goal}: {answer.message}")
            middle = median(spent[1:])
            steps = str(len(answer.steps)) if answer.success else answer.message[:60]
            figures = milliseconds(spent[0]), milliseconds(middle), f"<= {milliseconds(AIM)}"
            rows.append((goal, steps, *figures, verdict(middle <= AIM)))
        return rows


async def _drive(_: object) -> None:
    """Offer drives, as plans are not done."""


def _where(_: WhereIsRobotRequest) -> WhereIsRobotResponse:
    pose = RobotPose(robot="robi", room="Room 0", received_at=Time.from_seconds(0.0), limit=1e9)
    return WhereIsRobotResponse(success=True, pose=(pose,))


def _announce_all(index: DeviceIndex, now: float) -> None:
    for number in range(LAMPS):
        _announce(index, now, f"lamp {number}", "light", "on_off", value=False, room=f"Room {number % ROOMS}")
    for number in range(0, ROOMS - 1, MOTOR):
        _announce(index, now, f"motor {number}", "window_covering", "position", value=0.0, room=f"Room {number}")
    index.pop_changes()
    index.sort()


def _announce(
    index: DeviceIndex, now: float, name: str, kind: str, capability: str, *, value: float | bool, room: str
) -> None:
    able = Capability(name=capability, settable=True)
    part = Part(id="main", service_type=kind, capabilities=(able,), reads=(name,), writes=(f"{name}/set",))
    change: dict[str, object] = {"key": name, "name": name, "service_type": kind, "identifiers": (f"id:{name}",)}
    change |= {"parts": (part,), "area": room, "announced_on": f"x/{name}"}
    announced: Sighting = sighting(0, 0.0, confirmed=True).model_copy(update=change)
    index.observe(announced, now)
    reading = Reading(part="main", capability=capability, value=Value.of(value))
    at = Time.from_seconds(0.0)
    index.report(
        DeviceReport(gateway="mqtt", key=name, readings=(reading,), address=name, retained=False, received_at=at), now
    )


def _places() -> Places:
    rooms = tuple(
        HouseRoom(f"Room {number}", polygons=((((x, 0.0), (x + SIDE, 0.0), (x + SIDE, SIDE), (x, SIDE)),),))
        for number, x in ((one, one * SIDE) for one in range(ROOMS))
    )
    doors = tuple(
        HouseDoor(
            f"Door {number}",
            (f"Room {number}", f"Room {number + 1}"),
            contact="" if number % MOTOR else f"motor {number}",
        )
        for number in range(ROOMS - 1)
    )
    return Places(rooms, {}, doors)
