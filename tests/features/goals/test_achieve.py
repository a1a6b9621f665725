"""Goals are reached, or refused with the true reason; in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import anyio
import pytest
from tests.control.conftest import Home, ignore
from tests.features.goals.conftest import Family, goals_of
from tests.features.scenes.conftest import Kept, Scenes, served
from tests.one_task import in_one_task

from homebot.devices.command_messages import Setting
from homebot.devices.handles import Light
from homebot.devices.lease_messages import HoldRequest
from homebot.devices.names import ANSWER_QUESTION, OPEN_QUESTIONS
from homebot.devices.question_messages import AnswerQuestion, AnswerQuestionRequest, OpenQuestions
from homebot.graph import qos_profile_latched
from homebot.graph.actions import GoalState

pytestmark = pytest.mark.virtual_time


@pytest.mark.parametrize(
    ("goal", "steps"),
    [
        ("hall lit", {"turn on Hall Lamp"}),
        ("the hall is lit", {"turn on Hall Lamp"}),
        ("hall dark", set()),
        ("hall lamp on and living lamp on", {"turn on Hall Lamp", "turn on Living Lamp"}),
        ("lights in kitchen on", {"turn on Kitchen Lamp", "turn on Kitchen Spot"}),
        ("rosie in hall", set()),
        ("rosie in living", {"rosie drives to Living"}),
        ("rosie in the kitchen", {"open Kitchen Motor", "rosie drives to Kitchen"}),
        ("kitchen motor open", {"open Kitchen Motor"}),
        ("study lock unlocked", {"unlock Study Lock"}),
        ("study motor open", {"open Study Motor"}),
        ("study lit, rosie in living", {"turn on Study Lamp", "rosie drives to Living"}),
    ],
)
async def test_a_goal_is_reached(family: Family, goal: str, steps: set[str]) -> None:
    if goal == "study motor open":
        await family.home.report("study lock", "lock", "unlocked")
    answer = await family.achieve(goal)
    assert answer.success, answer.message
    assert set(family.steps(answer)) == steps
    assert (await family.achieve(goal)).message == f"{goal!r} is so already"


async def test_one_lamp_is_enough_for_a_lit_room(family: Family) -> None:
    answer = await family.achieve("kitchen lit and rosie in kitchen")
    assert answer.message == "'kitchen lit and rosie in kitchen' is reached"
    assert len(answer.steps) == 3
    assert (family.room, family.drives) == ("Kitchen", ["Kitchen"])


async def test_a_goal_and_its_steps_are_told_in_the_language_of_the_house(home: Home) -> None:
    family = Family(home)
    await family.furnish()
    async with in_one_task(goals_of(home, "de")):
        answer = await family.achieve("Kitchen hell und rosie in der Kitchen")
        assert answer.message == "'Kitchen hell und rosie in der Kitchen' ist erreicht"
        assert set(family.steps(answer)) == {
            "Kitchen Motor öffnen",
            "rosie fährt nach Kitchen",
            "Kitchen Lamp einschalten",
        }
        assert {step.outcome.partition(" nach ")[0] for step in answer.steps} == {"bestätigt", "erledigt"}
        told = await family.achieve("front door open")
        assert told.message == (
            "'front door open' ist nicht erreichbar: Front Contact ist zu, und nichts hier kann das ändern"
        )


async def test_a_dry_run_shows_the_plan_and_changes_nothing(family: Family) -> None:
    answer = await family.achieve("rosie in kitchen and hall lit", is_dry_run=True)
    assert answer.message == "'rosie in kitchen and hall lit' would be reached"
    assert set(family.steps(answer)) == {"open Kitchen Motor", "rosie drives to Kitchen", "turn on Hall Lamp"}
    assert (family.home.commands, family.drives) == ([], [])


async def test_the_plan_is_shown_before_its_first_step(family: Family) -> None:
    await family.achieve("hall lit")
    assert [one.outcome for one in family.feedback[0].steps] == [""]
    assert family.feedback[-1].steps[0].outcome.startswith("confirmed")


async def test_a_locked_door_on_the_way_is_unlocked_after_asking(family: Family) -> None:
    answer = await family.achieve("rosie in study", is_dry_run=True)
    assert family.steps(answer) == ["unlock Study Lock", "open Study Motor", "rosie drives to Study"]
    assert answer.steps[0].asks


async def test_without_an_answer_the_lock_is_the_reason(family: Family) -> None:
    answer = await family.achieve("rosie in study")
    assert not answer.success
    assert "Study door is locked, and unlock Study Lock is not possible" in answer.message
    assert "nobody answered" in answer.message
    assert (family.home.commands, family.drives) == ([], [])


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ("rosie in bath", "Bath door is closed, and nothing here can change that"),
        ("rosie in attic", "rosie is in Hall, and nothing here can change that"),
        ("front contact open", "Front Contact is closed, and nothing here can change that"),
        ("hall lit and hall dark", "each wish can be reached, but not all at once"),
        ("hal lit", "there is no room 'hal'; did you mean Hall?"),
        ("marvin in hall", "there is no robot 'marvin'; robots are rosie"),
        ("lights in hall", "; of devices name the state too, as in 'lights in hall on'"),
        ("bath lit", "Bath lit: no lamp is known in Bath"),
        ("hall lamp", "'hall lamp' names no state"),
        ("on", "'on' names no device or no state"),
        ("rosie in hall and rosie in living", "rosie cannot be in Hall and in Living at once"),
        ("rosie in living and rosie not in living", "each wish can be reached, but not all at once"),
        ("anna is home", "'anna is home' names no state; write it like"),
        ("hall lamp halfway", "'hall lamp halfway' names no state; write it like"),
        ("  ", "the goal is empty"),
        ("hall at 21 °C", "nothing in Hall takes 21 °C"),
    ],
)
async def test_what_cannot_be_reached_says_why(family: Family, goal: str, reason: str) -> None:
    answer = await family.achieve(goal)
    assert not answer.success
    assert reason in answer.message
    assert (family.home.commands, family.drives) == ([], [])


async def test_another_lamp_takes_the_place_of_one_that_does_not_obey(family: Family) -> None:
    (first,) = family.steps(await family.achieve("kitchen lit", is_dry_run=True))
    family.home.behaviours[first.removeprefix("turn on ").lower()] = ignore
    answer = await family.achieve("kitchen lit")
    assert answer.success, answer.message
    assert {first, *family.steps(answer)} == {"turn on Kitchen Lamp", "turn on Kitchen Spot"}
    assert answer.tried[0].startswith(f"{first}: no answer")


async def test_a_lamp_that_somebody_turns_off_meanwhile_is_turned_on_again(family: Family) -> None:
    goal = await family.begin("hall lit and rosie in living")
    await anyio.sleep(5.0)
    await family.home.report("hall lamp", "on_off", value=False)
    answer = (await goal.result())[1]
    assert answer.success, answer.message
    assert answer.tried == ("after all steps, Hall is not lit",)


async def test_when_no_lamp_obeys_the_reason_is_the_outcome(family: Family) -> None:
    family.home.behaviours["hall lamp"] = ignore
    answer = await family.achieve("hall lit")
    assert "turn on Hall Lamp is not possible: no answer" in answer.message
    assert len(answer.tried) == 1


async def test_a_person_who_closes_a_door_on_the_way_leads_to_a_new_plan(family: Family) -> None:
    goal = await family.begin("rosie in kitchen")
    await anyio.sleep(4.0)
    assert family.drives == ["Kitchen"]
    await family.home.report("kitchen motor", "position", 0.0)
    answer = (await goal.result())[1]
    assert answer.success, answer.message
    assert answer.tried == ("rosie drives to Kitchen: Kitchen door is closed",)
    assert family.drives == ["Kitchen", "Kitchen"]


async def test_a_person_who_closes_it_each_time_ends_the_goal(family: Family) -> None:
    goal = await family.begin("rosie in kitchen")
    for _ in range(4):
        await anyio.sleep(3.0)
        await family.home.report("kitchen motor", "position", 0.0)
    answer = (await goal.result())[1]
    assert not answer.success
    assert len(answer.tried) == 4
    assert answer.message.endswith("Kitchen door is closed")


async def test_of_two_goals_that_fight_the_second_is_refused(family: Family) -> None:
    first = await family.begin("rosie in kitchen")
    await anyio.sleep(4.0)
    second = await family.achieve("rosie in living", issuer="client:ben")
    assert not second.success
    assert "the goal 'rosie in kitchen' of the client anna" in second.message
    assert (await first.result())[1].success


async def test_a_wish_that_is_so_is_kept_until_the_goal_ends(family: Family) -> None:
    await family.achieve("living lit")
    first = await family.begin("living lit and rosie in kitchen")
    await anyio.sleep(4.0)
    second = await family.achieve("living dark", issuer="client:ben")
    assert second.message == (
        "'living dark' has to wait: the goal 'living lit and rosie in kitchen' of the client anna is under way, and "
        "needs 'Living lit'; ask again when it has ended, or cancel it"
    )
    assert (await family.achieve("hall lit", issuer="client:ben")).success
    assert (await first.result())[1].success
    assert (await family.achieve("living dark", issuer="client:ben")).success


async def test_a_cancelled_goal_calls_the_robot_off_and_says_what_is_done(family: Family) -> None:
    goal = await family.begin("rosie in kitchen")
    await anyio.sleep(4.0)
    goal.request_cancel()
    state, answer = await goal.result()
    assert (state, answer.message) == (GoalState.CANCELED, "cancelled; 1 of 2 steps are done")
    assert family.room == "Hall"


async def test_a_robot_between_two_rooms_is_on_its_way(family: Family) -> None:
    family.is_lost_on_its_way, family.lag = True, 3.0
    answer = await family.achieve("rosie in kitchen")
    assert answer.message == "'rosie in kitchen' is reached"
    assert (family.drives, answer.tried) == (["Kitchen"], ())


async def test_a_robot_leaves_for_a_room_that_no_wish_excludes(family: Family) -> None:
    family.room = "Living"
    answer = await family.achieve("rosie not in living and rosie not in hall")
    assert answer.success, answer.message
    assert family.drives == ["Kitchen"]


async def test_a_robot_that_does_not_know_where_it_is_is_the_reason(family: Family) -> None:
    family.room = ""
    answer = await family.achieve("rosie in kitchen")
    assert answer.message.startswith("'rosie in kitchen' cannot be reached: the room of rosie is unknown")
    assert family.drives == []


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (1, "is reached"),
        (
            2,
            "rosie drives to Living is not possible: action /rosie/navigate_to_pose aborted the goal: sent away by Ben",
        ),
    ],
)
async def test_a_robot_that_is_sent_elsewhere_is_sent_once_more(family: Family, times: int, message: str) -> None:
    family.sent_elsewhere = times
    answer = await family.achieve("rosie in living")
    assert answer.message.endswith(message)
    assert family.drives == ["Living", "Living"]
    assert len(answer.tried) == times - 1


async def test_a_robot_that_leaves_on_its_way_is_the_reason(family: Family) -> None:
    goal = await family.begin("rosie in kitchen")
    await anyio.sleep(4.0)
    family.navigation.close()
    answer = (await goal.result())[1]
    assert not answer.success
    assert (
        "rosie drives to Kitchen is not possible: no robot offers the action /rosie/navigate_to_pose" in answer.message
    )


async def test_a_door_is_closed_before_it_is_locked(family: Family) -> None:
    for key, capability, value in (("study lock", "lock", "unlocked"), ("study motor", "position", 100.0)):
        await family.home.report(key, capability, value)
    answer = await family.achieve("study door locked and closed")
    assert family.steps(answer) == ["close Study Motor", "lock Study Lock"]
    assert answer.success, answer.message


async def test_a_cover_that_is_closing_is_not_open(family: Family) -> None:
    family.home.put("hall blind", "window_covering", "movement", "position", area="Hall")
    await family.home.report("hall blind", "position", 80.0)
    await family.home.report("hall blind", "movement", "closing")
    assert family.steps(await family.achieve("hall blind open", is_dry_run=True)) == ["open Hall Blind"]


class TestScenes:
    @pytest.fixture
    async def scenes(self, family: Family) -> AsyncIterator[Scenes]:
        async with in_one_task(served(family.home, Kept())) as scenes:
            values = [{"key": "kitchen lamp", "value": "on"}, {"key": "kitchen spot", "value": "on"}]
            saved = await scenes.change(name="Cooking", change="save", values=values)
            assert saved.success, saved.message
            yield scenes

    @pytest.mark.parametrize("goal", ["cooking", "lights in kitchen on"])
    async def test_a_scene_makes_all_its_wishes_true_at_once(self, family: Family, scenes: Scenes, goal: str) -> None:
        answer = await family.achieve(goal)
        assert (answer.message, family.steps(answer)) == (f"{goal!r} is reached", ["apply scene Cooking"])
        assert (await scenes.shown("Cooking")).can_undo

    @pytest.mark.usefixtures("scenes")
    async def test_a_scene_is_no_way_to_one_of_its_wishes(self, family: Family) -> None:
        assert family.steps(await family.achieve("kitchen spot on")) == ["turn on Kitchen Spot"]

    @pytest.mark.usefixtures("scenes")
    async def test_a_lamp_that_does_not_obey_a_scene_is_commanded_by_itself(self, family: Family) -> None:
        family.home.behaviours["kitchen spot"] = ignore
        answer = await family.achieve("cooking")
        assert answer.tried[0].startswith("apply scene Cooking: Kitchen Spot: no answer")
        assert "turn on Kitchen Spot is not possible: no answer" in answer.message

    @pytest.mark.usefixtures("scenes")
    async def test_what_a_client_may_not_command_is_not_done_by_a_scene(self, family: Family) -> None:
        answer = await family.achieve("cooking", scope=("read", 'act: name="Kitchen Lamp"'))
        assert "turn on Kitchen Spot is not possible: client:anna may not command kitchen_spot" in answer.message
        assert family.home.commands == []

    async def test_a_lock_of_a_scene_stays_locked_after_a_no(self, family: Family, scenes: Scenes) -> None:
        values = [{"key": "study lock", "value": "unlocked"}, {"key": "hall lamp", "value": "on"}]
        await scenes.change(name="Leaving", change="save", values=values)
        owner, goal = Owner(family.home), await family.begin("leaving")
        assert await owner.answer(await owner.question(), yes=False) == ""
        assert "unlock Study Lock is not possible: refused (ask): client:owner said no" in (
            (await goal.result())[1].message
        )
        await anyio.sleep(100.0)
        assert [one.key for one in family.home.commands] == ["hall lamp"]

    async def test_a_lock_of_a_scene_asks_each_time(self, family: Family, scenes: Scenes) -> None:
        values = [{"key": "study lock", "value": "unlocked"}, {"key": "hall lamp", "value": "on"}]
        await scenes.change(name="Leaving", change="save", values=values)
        await family.achieve("hall lit")
        (step,) = (await family.achieve("leaving", is_dry_run=True)).steps
        assert (step.text, bool(step.asks)) == ("unlock Study Lock", True)
        (step,) = (await family.achieve("leaving and study lock unlocked", is_dry_run=True)).steps
        assert (step.text, step.asks) == ("unlock Study Lock", "")

    @pytest.mark.usefixtures("scenes")
    async def test_a_scene_says_that_a_client_with_the_right_ask_asks(self, family: Family) -> None:
        scope = ("read", "act: all", 'ask: name="Kitchen Spot"')
        (step,) = (await family.achieve("cooking", is_dry_run=True, scope=scope)).steps
        assert (step.text, step.asks) == ("apply scene Cooking", "its client may only ask")

    @pytest.mark.usefixtures("scenes")
    async def test_of_many_wishes_the_two_that_undo_each_other_are_named(self, family: Family) -> None:
        assert (await family.achieve("cooking and kitchen spot off")).message.endswith(
            "not all at once: Kitchen Spot: scene Cooking and Kitchen Spot: kitchen spot off"
        )

    async def test_a_scene_of_a_bridge_that_tells_no_values_is_applied(self, family: Family, scenes: Scenes) -> None:
        family.home.put("relax", "x_scene", "scene", area="Hall")
        (native,) = [one for one in (await scenes.listed()).scenes if one.is_native]
        answer = await family.achieve(f"scene {native.name}")
        assert (answer.success, family.steps(answer)) == (True, [f"apply scene {native.name}"])


async def test_a_client_that_may_not_act_is_refused_before_the_first_step(family: Family) -> None:
    answer = await family.achieve("hall lit", scope=("read",))
    assert not answer.success
    assert "turn on Hall Lamp is not possible" in answer.message
    assert family.home.commands == []


async def test_a_lock_that_the_owner_has_to_grant_is_no_step_of_an_app(family: Family) -> None:
    answer = await family.achieve("study lock unlocked", issuer="/app", scope=())
    assert not answer.success
    assert "unlock Study Lock is not possible" in answer.message
    assert family.home.commands == []


async def test_what_another_holds_is_the_reason(family: Family) -> None:
    hall = await family.home.handle(Light, "hall lamp")
    off = Setting.of("on_off", plain=False)
    held = HoldRequest(
        device=hall.device.id, setting=off, lease="film", by="Film night", ttl=900.0, issuer="client:ben"
    )
    assert (await family.home.hold(held)).held
    answer = await family.achieve("hall lit", issuer="/app", scope=())
    assert not answer.success
    assert "Film night" in answer.message


class Owner:
    """A person who answers the questions of goals."""

    def __init__(self, home: Home) -> None:
        self.asked: list[OpenQuestions] = []
        home.app.create_subscription(OpenQuestions, OPEN_QUESTIONS, self.asked.append, qos_profile_latched)
        self.client = home.app.create_client(AnswerQuestion, ANSWER_QUESTION)

    async def question(self) -> str:
        """Return the question that is open soon."""
        await anyio.sleep(5.0)
        return self.asked[-1].questions[0].question

    async def answer(self, question: str, *, yes: bool, issuer: str = "client:owner") -> str:
        """Return why the answer does not count; empty if it does."""
        asked = AnswerQuestionRequest(question=question, yes=yes, issuer=issuer, scope=("act: all",))
        return (await self.client.call(asked)).message


@pytest.mark.parametrize(("yes", "room"), [(True, "Study"), (False, "Hall")])
async def test_a_person_decides_on_a_lock_on_the_way(family: Family, *, yes: bool, room: str) -> None:
    owner, goal = Owner(family.home), await family.begin("rosie in study")
    for _ in range(2 if yes else 1):
        assert await owner.answer(await owner.question(), yes=yes) == ""
    answer = (await goal.result())[1]
    assert answer.success == yes, answer.message
    assert family.room == room
    assert yes or "owner said no" in answer.message


async def test_a_goal_waits_most_of_a_minute_for_each_yes(family: Family) -> None:
    owner, goal = Owner(family.home), await family.begin("rosie in study")
    for seconds in (20.0, 50.0):
        question = await owner.question()
        await anyio.sleep(seconds)
        assert await owner.answer(question, yes=True) == ""
    answer = (await goal.result())[1]
    assert (answer.success, answer.tried, family.room) == (True, (), "Study")


async def test_the_plan_says_what_a_client_with_the_right_ask_asks(family: Family) -> None:
    answer = await family.achieve("hall lit, kitchen lit", is_dry_run=True, scope=("read", "act: all", "ask: in hall"))
    asks = {one.text: one.asks for one in answer.steps}
    assert asks.pop("turn on Hall Lamp") == "its client may only ask"
    assert [*asks.values()] == [""]


async def test_of_two_answers_the_first_counts_and_the_second_is_told(family: Family) -> None:
    owner, goal = Owner(family.home), await family.begin("rosie in study")
    question = await owner.question()
    assert await owner.answer(question, yes=False) == ""
    second = await owner.answer(question, yes=True, issuer="client:ben")
    assert second == "the question is over: client:owner said no"
    assert "client:owner said no" in (await goal.result())[1].message
    assert (family.home.commands, family.drives) == ([], [])


async def test_after_a_cancelled_goal_its_question_is_over_and_no_step_is_taken(family: Family) -> None:
    owner, goal = Owner(family.home), await family.begin("rosie in study and hall lit")
    question = await owner.question()
    goal.request_cancel()
    state, answer = await goal.result()
    assert (state, answer.message) == (GoalState.CANCELED, "cancelled; 1 of 4 steps are done")
    assert await owner.answer(question, yes=True) == "the question is over: the client anna asks no more"
    await anyio.sleep(100.0)
    assert ([one.key for one in family.home.commands], family.drives) == (["hall lamp"], [])


async def test_a_yes_after_the_minute_takes_no_step(family: Family) -> None:
    owner, goal = Owner(family.home), await family.begin("rosie in study")
    question = await owner.question()
    await goal.result()
    assert (await owner.answer(question, yes=True)).startswith("the question is over: nobody answered within 60 s")
    await anyio.sleep(100.0)
    assert (family.home.commands, family.drives) == ([], [])


async def test_a_yes_to_a_door_that_was_locked_meanwhile_opens_nothing(family: Family) -> None:
    await family.home.report("study lock", "lock", "unlocked")
    owner, goal = Owner(family.home), await family.begin("rosie in study")
    question = await owner.question()
    await family.home.report("study lock", "lock", "locked")
    await anyio.sleep(2.0)
    assert await owner.answer(question, yes=True) == "the question is over: the client anna asks no more"
    unlock = await owner.question()
    goal.request_cancel()
    assert (await goal.result())[1].tried == ("open Study Motor: Study door is locked",)
    assert (family.home.commands, unlock != question) == ([], True)


async def test_a_goal_that_waits_for_a_door_is_cancelled(family: Family) -> None:
    family.home.behaviours["kitchen motor"] = ignore
    goal = await family.begin("rosie in kitchen")
    await anyio.sleep(3.0)
    goal.request_cancel()
    state, answer = await goal.result()
    assert (state, answer.message) == (GoalState.CANCELED, "cancelled; 0 of 2 steps are done")
    await anyio.sleep(100.0)
    assert ({one.key for one in family.home.commands}, family.drives) == ({"kitchen motor"}, [])


class TestQuietHours:
    @pytest.fixture
    def home_settings(self) -> dict[str, Any]:
        return {"quiet_hours": [{"start": "00:00", "end": "23:59", "commands": ["turn on lights"]}]}

    async def test_no_step_is_planned_against_a_policy(self, family: Family) -> None:
        answer = await family.achieve("study lit and rosie in living", issuer="/app", scope=())
        assert not answer.success
        assert "turn on Study Lamp is not possible" in answer.message
        assert "(quiet_hours)" in answer.message
        assert family.home.commands == []
