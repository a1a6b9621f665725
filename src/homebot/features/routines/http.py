"""The route of the HTTP API for routines."""

from typing import Annotated, Final

from pydantic import Field

from homebot.bridges.home_api.answers import call_or_fail
from homebot.bridges.home_api.device_search import HomeCalls
from homebot.bridges.home_api.routes import ApiRoute
from homebot.bridges.home_api.shapes import Answer, PrintableText, Question
from homebot.features.routines import PROPOSE_ROUTINE


class RoutineQuestion(Question):
    """A routine to propose: its table `[[routines]]` in TOML."""

    text: Annotated[str, Field(max_length=20_000)]


class ProposalAnswer(Answer):
    """The result of a proposal; the routine does not start until the owner enables it."""

    text: PrintableText


async def propose_routine(home: HomeCalls, asked: RoutineQuestion) -> ProposalAnswer:
    """Propose a routine to the owner, who enables it or not, and return its faults in the house now."""
    answer = await call_or_fail(home, PROPOSE_ROUTINE.name, {"text": asked.text})
    return ProposalAnswer(text=str(answer.message))


ROUTES: Final = (ApiRoute("POST", "/api/routines", RoutineQuestion, ProposalAnswer, propose_routine),)
