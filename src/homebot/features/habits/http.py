"""The route of the HTTP API for habits."""

from http import HTTPStatus
from typing import Annotated, Final, cast

from pydantic import Field

from homebot.bridges.home_api.answers import call_or_fail
from homebot.bridges.home_api.device_search import HomeCalls
from homebot.bridges.home_api.routes import ApiRoute
from homebot.bridges.home_api.shapes import Answer, NoQuestion, PrintableText, ProblemError
from homebot.features.habits import SUGGEST_HABITS
from homebot.features.habits.messages import SuggestHabitsResponse


class HabitLine(Answer):
    """A habit of the people in the house, with the routine that would act as they do, and its proof."""

    name: PrintableText
    text: Annotated[str, Field(max_length=2000)] = ""
    proof: PrintableText
    precision: float = 0.0
    recall: float = 0.0


class HabitList(Answer):
    """The habits that the owner may accept as routines."""

    habits: tuple[HabitLine, ...]


async def list_habits(home: HomeCalls, _: NoQuestion) -> HabitList:
    """Return the routines that are proposed of habits; the owner alone accepts or rejects them."""
    if not home.offers(SUGGEST_HABITS.name):
        raise ProblemError(HTTPStatus.SERVICE_UNAVAILABLE, "this homebot proposes nothing")
    answer = cast("SuggestHabitsResponse", await call_or_fail(home, SUGGEST_HABITS.name, {}))
    return HabitList(
        habits=tuple(
            HabitLine(
                name=proposal.name,
                text=proposal.text,
                proof=proposal.proof,
                precision=proposal.precision,
                recall=proposal.recall,
            )
            for proposal in answer.proposals
        )
    )


ROUTES: Final = (ApiRoute("GET", "/api/habits", NoQuestion, HabitList, list_habits),)
