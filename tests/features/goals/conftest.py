"""Fixtures: the home of a family with doors, locks and a robot, in virtual time, and the action."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Final

import anyio
import pytest
from anyio.lowlevel import checkpoint
from tests.control.conftest import Home, home, home_settings, open_home
from tests.one_task import in_one_task

from homebot.devices.names import IMPORT_PLACES, WHERE_IS_ROBOT
from homebot.devices.places_messages import ImportPlaces, ImportPlacesRequest
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.features.goals import ACHIEVE
from homebot.features.goals.achieve_server import AchieveServer
from homebot.features.goals.messages import Achieve, AchieveFeedback, AchieveGoal, AchieveResult
from homebot.graph import Node
from homebot.graph.actions import ActionClient, ActionServer, ClientGoal
from homebot.messages import Time
from homebot.messages.definition import zero_message
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message

__all__ = ["Family", "family", "goals_of", "home", "home_settings", "open_home"]

ROOMS: Final = ("Hall", "Living", "Kitchen", "Study", "Bath", "Attic")
DOORS: Final = {
    "Living door": ("Hall", "Living"),
    "Kitchen door": ("Living", "Kitchen"),
    "Study door": ("Hall", "Study"),
    "Bath door": ("Hall", "Bath"),
    "Front door": ("Hall", "outside"),
}
"""The kitchen has a motor, the study a motor and a lock, the bath only a contact, the living room no device; no door
leads to the attic."""

NAVIGATE: Final = find_action("nav2_msgs/action/NavigateToPose")
METRES: Final = 10.0


class Family:
    """The home, whose robot ``rosie`` is in the hall and takes ten seconds for a drive.

    Attributes:
        lag: Seconds after its arrival until it says where it is.
        is_lost_on_its_way: Whether it is between two rooms then.
        sent_elsewhere: How many of its next drives somebody ends.
    """

    def __init__(self, home: Home) -> None:
        self.home = home
        self.room = "Hall"
        self.lag = 0.0
        self.is_lost_on_its_way = False
        self.sent_elsewhere = 0
        self.drives: list[str] = []
        self.feedback: list[AchieveFeedback] = []
        home.app.create_service(WhereIsRobot, WHERE_IS_ROBOT, self._where)
        self.navigation = ActionServer(home.app, NAVIGATE, "/rosie/navigate_to_pose", self._drive)

    async def furnish(self) -> None:
        """Put the devices and state the places."""
        for room in ("hall", "living", "kitchen", "study"):
            self.home.put(f"{room} lamp", "light", "on_off", area=room.title())
            await self.home.report(f"{room} lamp", "on_off", value=False)
        self.home.put("kitchen spot", "light", "on_off", area="Kitchen")
        await self.home.report("kitchen spot", "on_off", value=False)
        for key, kind in (("kitchen motor", "window_covering"), ("study motor", "closure")):
            self.home.put(key, kind, "position", area="Hall")
            await self.home.report(key, "position", 0.0)
        self.home.put("study lock", "door_lock", "lock", area="Hall")
        await self.home.report("study lock", "lock", "locked")
        for key in ("bath contact", "front contact"):
            self.home.put(key, "contact_sensor", readable=("contact",), area="Hall")
            await self.home.report(key, "contact", value=False)
        await anyio.sleep(0.01)
        answer = await self.home.app.create_client(ImportPlaces, IMPORT_PLACES).call(
            ImportPlacesRequest(text=_places())
        )
        assert answer.success, answer.message

    async def achieve(self, goal: str, **more: Any) -> AchieveResult:
        return (await (await self.begin(goal, **more)).result())[1]

    async def begin(self, goal: str, **more: Any) -> ClientGoal[AchieveResult, AchieveFeedback]:
        await anyio.sleep(0.01)
        client = ActionClient(self.home.app, Achieve, ACHIEVE.name)
        asked = AchieveGoal(goal=goal, **{"issuer": "client:anna", "scope": ("read", "act: all"), **more})
        return await client.send_goal(asked, self.feedback.append)

    def steps(self, answer: AchieveResult) -> list[str]:
        return [one.text for one in answer.steps]

    def _where(self, request: WhereIsRobotRequest) -> WhereIsRobotResponse:
        if request.robot not in ("rosie", ""):
            message = f"there is no robot {request.robot!r}; robots are rosie"
            return WhereIsRobotResponse(success=False, message=message, is_mistake=True)
        pose = RobotPose(robot="rosie", room=self.room, received_at=Time(sec=0, nanosec=0), limit=math.inf)
        return WhereIsRobotResponse(success=True, pose=(pose,), robot=pose.robot, is_sole=True)

    async def _drive(self, goal: Any) -> None:
        room = ROOMS[int(goal.request.pose.pose.position.x // METRES)]
        self.drives.append(room)
        before, self.room = self.room, "" if self.is_lost_on_its_way else self.room
        await anyio.sleep(10.0)
        self.room = before
        kind: type[Message] = NAVIGATE.Result
        result = zero_message(kind)
        if self.sent_elsewhere:
            self.sent_elsewhere -= 1
            goal.abort(result.model_copy(update={"error_msg": "sent away by Ben"}))
            return
        self.home.tasks.start_soon(self._arrive, room)
        goal.succeed(result)

    async def _arrive(self, room: str) -> None:
        await anyio.sleep(self.lag)
        self.room = room


def _places() -> str:
    lines = []
    for number, room in enumerate(ROOMS):
        left, right = METRES * number, METRES * number + 5.0
        lines += [f"[places.rooms.{room}]", f"polygon = [[{left}, 0.0], [{right}, 0.0], [{right}, 5.0], [{left}, 5.0]]"]
    devices = {
        "Kitchen door": 'contact = "Kitchen Motor"',
        "Study door": 'contact = "Study Motor"\nlock = "Study Lock"',
        "Bath door": 'contact = "Bath Contact"',
        "Front door": 'contact = "Front Contact"',
    }
    for name, (one, other) in DOORS.items():
        lines += ["[[places.doors]]", f'name = "{name}"', f'rooms = ["{one}", "{other}"]', devices.get(name, "")]
    return "\n".join(lines)


@pytest.fixture
async def family(home: Home) -> AsyncIterator[Family]:
    """The furnished home."""
    found = Family(home)
    await found.furnish()
    async with in_one_task(goals_of(home)):
        yield found


@asynccontextmanager
async def goals_of(home: Home, language: str = "") -> AsyncIterator[None]:
    async with Node(home.graph, "goals") as node:
        AchieveServer(node, language, lambda: home.control, {}, checkpoint).serve(ACHIEVE.name)
        yield
