"""Goals of a ROS 2 robot, and drives of one."""

from __future__ import annotations

import anyio
import anyio.lowlevel
import pytest
from tests.control.conftest import OpenHome
from tests.features.goals.conftest import NAVIGATE, Family, goals_of
from tests.features.ros2.pair import pair
from tests.features.ros2.test_goals import all_parts
from tests.patience import PATIENCE

from homebot.features.goals import ACHIEVE
from homebot.features.goals.messages import Achieve, AchieveFeedback, AchieveGoal
from homebot.graph import Node
from homebot.graph.actions import ActionClient, ActionServer, GoalState


@pytest.mark.parametrize(
    ("right", "text"), [("act: all", "'lamp on' is reached"), ("act: lock", "rosie may not command")]
)
async def test_a_robot_achieves_a_goal_with_the_rights_of_its_token(open_home: OpenHome, right: str, text: str) -> None:
    feedback: list[AchieveFeedback] = []
    async with (
        open_home() as home,
        goals_of(home),
        pair("read", right, export="/devices/**", house=home.graph) as both,
        Node(both.robot, "nav") as nav,
    ):
        await home.lamp("on_off", before={"on_off": False})
        with anyio.fail_after(PATIENCE):
            await all_parts(both.robot, ACHIEVE.name)
            asked = AchieveGoal(goal="lamp on", issuer="client:owner", scope=("act: all",))
            goal = await ActionClient(nav, Achieve, ACHIEVE.name).send_goal(asked, feedback.append)
            answer = (await goal.result())[1]
            while answer.success and not any(one.steps[0].outcome.startswith("confirmed") for one in feedback):
                await anyio.lowlevel.checkpoint()  # on the wire feedback may come after the result
        assert text in answer.message
        assert len(home.commands) == len(answer.steps) == (right == "act: all")


async def test_a_robot_stops_when_the_goal_that_it_drives_for_is_cancelled(open_home: OpenHome) -> None:
    began, ended = anyio.Event(), anyio.Event()

    async def drive(_: object) -> None:
        began.set()
        try:
            await anyio.sleep_forever()
        finally:
            ended.set()

    async with (
        open_home() as home,
        goals_of(home),
        pair("read", "robot: rosie", house=home.graph) as both,
        Node(both.robot, "nav", namespace="/rosie") as nav,
    ):
        family = Family(home)
        family.navigation.close()
        ActionServer(nav, NAVIGATE, "navigate_to_pose", drive)
        await family.furnish()
        with anyio.fail_after(PATIENCE):
            await all_parts(home.graph, "/rosie/navigate_to_pose")
            goal = await family.begin("rosie in living")
            await began.wait()
            goal.request_cancel()
            state, answer = await goal.result()
            assert (state, answer.message) == (GoalState.CANCELED, "cancelled; 0 of 1 steps are done")
            await ended.wait()
