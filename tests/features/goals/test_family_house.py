"""Goals in the family house and with its robot: reached, or refused with the true reason; in virtual time."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree

import anyio
import pytest
from structlog.testing import capture_logs
from tests.features.goals.family_house import DASH, family_house
from tests.whole_house import WHOLE_HOUSE

from homebot.features.goals.messages import AchieveResult
from homebot.graph.actions import GoalState

pytestmark = [pytest.mark.virtual_time, WHOLE_HOUSE, pytest.mark.rooms("scenes")]

REACHED = {
    "kitchen lit": ["turn on kitchen_lamp"],
    "the kitchen is lit and the robot is in the kitchen": ["open kitchen_slide", "robot drives to kitchen"],
    "robot not in kitchen": ["robot drives to living"],
    "living heat at 23 °C": ["set living_heat to 23 °C"],
    "living lamp at 40 %": ["set living_lamp to 40 %"],
    "film": ["apply scene Film"],
    "no lights on in living": ["turn off living_floor_lamp"],
    "kitchen slide closed, living cover closed": ["close kitchen_slide", "close living_cover"],
    "kitchen slide open, living cover open": ["open kitchen_slide", "open living_cover"],
    "front door unlocked": ["unlock front_lock"],
    "front door closed and locked": ["lock front_lock"],
    "stairs lit": ["turn on stairs_lamp"],
    "robot at the charging station": ["robot drives to its dock"],
    "house dark": ["turn off kitchen_lamp", "turn off stairs_lamp"],
}
IN_THE_WAY = {
    "robot in bath": f"bath{DASH}stairs is closed, and nothing here can change that",
    "bath door open": "bath_door is closed, and nothing here can change that",
    "robot in nursery": f"nursery{DASH}stairs is closed, and open nursery_slide is not possible: contradicted",
    "stairs floor lamp on": "stairs_floor_lamp is off, and turn on stairs_floor_lamp is not possible: contradicted",
    "robot in bedroom": f"bedroom{DASH}stairs is locked, and unlock bedroom_lock is not possible: refused (ask)",
    "hall lit and hall dark": "each wish can be reached, but not all at once",
    "robot in cellar": "there is no room 'cellar'",
    "hall lamp purple": "hall_lamp: the word 'purple'",
}


async def test_goals_are_reached_or_say_what_is_in_the_way() -> None:
    async with family_house() as house:
        for goal, steps in REACHED.items():
            answer = await house.achieve(goal)
            assert answer.success, answer.message
            assert sorted(one.text for one in answer.steps) == sorted(steps), goal
        before = house.told()
        for goal, reason in IN_THE_WAY.items():
            answer = await house.achieve(goal)
            assert not answer.success, goal
            assert reason in answer.message
        told = house.told()[len(before) :]
        assert {device for device, _ in told} == {"nursery_slide", "stairs_floor_lamp"}  # only to find out


async def test_another_lamp_serves_when_the_first_does_not_obey() -> None:
    async with family_house() as house:
        answer = await house.achieve("stairs lit")
        assert answer.success, answer.message
        assert answer.tried[0].startswith("turn on stairs_floor_lamp: contradicted")
        assert [one.text for one in answer.steps] == ["turn on stairs_lamp"]


async def test_why_says_for_which_goal_the_robot_drove() -> None:
    async with family_house() as house:
        assert (await house.achieve("robot in living")).success
        assert (await house.why("robots/robot")).endswith(": robot drives to living for 'robot in living': done.")


async def test_a_door_that_a_person_closes_on_the_way_is_opened_again() -> None:
    async with family_house() as house:
        goal = await house.begin("robot in kitchen")
        await anyio.sleep(8.0)
        house.world.press("kitchen_slide", "close", house.world.now)
        answer = (await goal.result())[1]
        assert answer.success, answer.message
        assert answer.tried == (f"robot drives to kitchen: kitchen{DASH}living is closed",)
        opened = ["open kitchen_slide", "open kitchen_slide", "robot drives to kitchen"]
        assert [step.text for step in answer.steps] == opened


async def test_the_owner_lets_the_robot_through_a_locked_door() -> None:
    async with family_house() as house:
        goal = await house.begin("robot in bedroom")
        await house.answer(yes=True)
        answer = (await goal.result())[1]
        assert answer.success, answer.message
        assert house.told() == [("bedroom_lock", "unlock"), ("bedroom_slide", "open")]


async def test_of_two_goals_at_the_same_moment_for_one_robot_one_is_refused() -> None:
    async with family_house() as house, anyio.create_task_group() as tasks:
        answers: dict[str, AchieveResult] = {}

        async def achieve(room: str) -> None:
            answers[room] = await house.achieve(f"robot in {room}", issuer=f"client:{room}")

        tasks.start_soon(achieve, "living")
        tasks.start_soon(achieve, "stairs")
        await anyio.sleep(60.0)
        refused, reached = sorted(answers, key=lambda room: answers[room].success)
        assert answers[reached].success
        assert answers[refused].message == (
            f"'robot in {refused}' has to wait: the goal 'robot in {reached}' of the client {reached} is under way, "
            "and needs robot for itself; ask again when it has ended, or cancel it"
        )


async def test_a_goal_that_would_close_the_door_before_the_robot_is_refused() -> None:
    async with family_house() as house:
        await house.achieve("kitchen slide open")
        goal = await house.begin("robot in kitchen")
        await anyio.sleep(3.0)
        second = await house.achieve("kitchen slide closed")
        assert (
            f"'robot in kitchen' of the client anna is under way, and needs 'kitchen{DASH}living is open'"
            in second.message
        )
        assert (await goal.result())[1].success
        assert (await house.achieve("kitchen slide closed")).success


async def test_goals_that_do_not_fight_run_side_by_side() -> None:
    async with family_house() as house:
        goal = await house.begin("robot in kitchen")
        await anyio.sleep(8.0)
        assert (await house.achieve("hall lit")).success
        goal.request_cancel()
        assert (await goal.result())[0] == GoalState.CANCELED


async def test_the_next_start_says_which_goals_were_cut_off_and_after_which_step(tmp_path: Path) -> None:
    """As after a kill: with the files of the moment."""
    async with family_house(index_file=tmp_path / "before" / "index.sqlite") as house:
        await house.achieve("hall lit")
        cancelled = await house.begin("robot in kitchen")
        await anyio.sleep(8.0)
        cancelled.request_cancel()
        await cancelled.result()
        await house.begin("robot in bedroom")
        await house.answer(yes=True)
        await anyio.sleep(5.0)
        copytree(tmp_path / "before", tmp_path / "after")
    cut_off = (
        "the goal 'robot in bedroom' of the client anna was cut off when homebot ended, after unlock bedroom_lock: "
        "confirmed after 2 s (reported)"
    )
    with capture_logs() as logs:
        async with family_house(index_file=tmp_path / "after" / "index.sqlite") as house:
            for device in ("locks/bedroom_lock", "covers/bedroom_slide", "robots/robot"):
                assert (await house.why(device)).endswith(f": {cut_off}.")
            assert "cut off" not in await house.why("covers/kitchen_slide")
            assert (await house.achieve("bedroom lock unlocked")).success
            assert "cut off" not in await house.why("locks/bedroom_lock")
    assert [one["message"] for one in logs if one["event"] == "goals.cut_off"] == [cut_off]
    with capture_logs() as logs:
        async with family_house(index_file=tmp_path / "after" / "index.sqlite"):
            assert "goals.cut_off" not in {one["event"] for one in logs}


async def test_no_step_is_against_a_policy() -> None:
    quiet = {"control": {"quiet_hours": [{"start": "00:00", "end": "06:00", "commands": ["turn on lights"]}]}}
    async with family_house(quiet) as house:
        answer = await house.achieve("kitchen lit and robot in kitchen", issuer="/app", scope=())
        assert "turn on kitchen_lamp is not possible" in answer.message
        assert house.told() == []


async def test_a_client_that_may_only_read_hears_what_it_lacks() -> None:
    async with family_house() as house:
        answer = await house.achieve("kitchen lit", scope=("read",))
        assert "kitchen_lamp is off, and turn on kitchen_lamp is not possible" in answer.message
        assert house.told() == []
