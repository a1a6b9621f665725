"""The routes of the HTTP API for routines."""

from http import HTTPStatus
from typing import Annotated, Final, cast

from pydantic import Field

from homebot.bridges.home_api.answers import call_or_fail
from homebot.bridges.home_api.device_search import HomeCalls
from homebot.bridges.home_api.routes import ApiRoute
from homebot.bridges.home_api.shapes import Answer, PrintableText, ProblemError, Question
from homebot.devices.app_messages import RoutineInfo, RoutinesResponse
from homebot.devices.names import LIST_ROUTINES
from homebot.devices.value import ShortText
from homebot.devices.wording.time_format import iso
from homebot.features.routines import PROPOSE_ROUTINE
from homebot.support.names import find_name, no_such


class RoutineQuestion(Question):
    """A routine to propose: its table `[[routines]]` in TOML."""

    text: Annotated[str, Field(max_length=20_000)]


class ProposalAnswer(Answer):
    """The result of a proposal; the routine does not start until the owner enables it."""

    text: PrintableText


class RoutinesQuestion(Question):
    """A routine by its name; empty for all."""

    name: ShortText = ""


class RoutineLine(Answer):
    """A routine in its own words, with why it cannot work, and its newest notes."""

    name: PrintableText
    state: str
    when: tuple[PrintableText, ...] = ()
    conditions: tuple[PrintableText, ...] = ()
    steps: tuple[PrintableText, ...] = ()
    cannot: tuple[PrintableText, ...] = ()
    did: tuple[PrintableText, ...] = ()


class RoutineList(Answer):
    """Routines."""

    routines: tuple[RoutineLine, ...]


async def propose_routine(home: HomeCalls, asked: RoutineQuestion) -> ProposalAnswer:
    """Propose a routine to the owner, who enables it or not, and return its faults in the house now."""
    answer = await call_or_fail(home, PROPOSE_ROUTINE.name, {"text": asked.text})
    return ProposalAnswer(text=str(answer.message))


async def explain_routines(home: HomeCalls, asked: RoutinesQuestion) -> RoutineList:
    """Return the routines, or the one of the name, each with its newest notes and obstacles."""
    answer = cast("RoutinesResponse", await home.call(LIST_ROUTINES, {"check": True}))
    infos = {one.name: one for one in answer.routines}
    if asked.name:
        if not (name := find_name(asked.name, infos)):
            raise ProblemError(HTTPStatus.NOT_FOUND, no_such("routine", asked.name, infos))
        infos = {name: infos[name]}
    return RoutineList(routines=tuple(map(_line, infos.values())))


def _line(info: RoutineInfo) -> RoutineLine:
    texts = (f"{iso(note.at)} {note.text}" for note in info.notes)
    state = "proposed" if info.proposed_by and not info.enabled else "enabled" if info.enabled else "disabled"
    cannot = (info.problem, *info.hints, *(f"lacks the right to {query}" for query in info.lacks))
    return RoutineLine(
        name=info.name,
        state=state,
        when=info.when,
        conditions=info.conditions,
        steps=info.steps,
        cannot=tuple(filter(None, cannot)),
        did=tuple(texts),
    )


ROUTES: Final = (
    ApiRoute("POST", "/api/routines", RoutineQuestion, ProposalAnswer, propose_routine),
    ApiRoute("GET", "/api/routines", RoutinesQuestion, RoutineList, explain_routines),
)
