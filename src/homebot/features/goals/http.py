"""The route of the HTTP API for goals."""

from typing import Annotated, Final, cast

from pydantic import Field

from homebot.bridges.home_api.device_search import HomeCalls
from homebot.bridges.home_api.routes import ApiRoute
from homebot.bridges.home_api.shapes import Answer, PrintableText, Question
from homebot.features.goals import ACHIEVE_WORDS
from homebot.features.goals.messages import AchieveResponse
from homebot.features.goals.step_words import step_text


class GoalQuestion(Question):
    """A goal in words, such as `kitchen lit and rosie in kitchen`; with `dry_run` only its plan is made."""

    goal: Annotated[str, Field(max_length=1000)]
    dry_run: bool = False


class GoalAnswer(Answer):
    """The plan with the outcomes of its steps, and whether the goal is reached, or the fact that is in the way."""

    reached: bool
    text: PrintableText
    steps: tuple[PrintableText, ...] = ()
    tried: tuple[PrintableText, ...] = ()


async def achieve(home: HomeCalls, asked: GoalQuestion) -> GoalAnswer:
    """Plan for a goal and, unless only the plan is wanted, do it."""
    request = {"goal": asked.goal, "is_dry_run": asked.dry_run}
    answer = cast("AchieveResponse", await home.call(ACHIEVE_WORDS.name, request))
    steps = tuple(map(step_text, answer.steps))
    return GoalAnswer(reached=answer.success, text=answer.message, steps=steps, tried=answer.tried)


ROUTES: Final = (ApiRoute("POST", "/api/goal", GoalQuestion, GoalAnswer, achieve),)
