"""The routes of the HTTP API for scenes."""

from http import HTTPStatus
from typing import Annotated, Final, cast

from pydantic import Field

from homebot.bridges.home_api.answers import call_or_fail, outcome_of
from homebot.bridges.home_api.device_search import HomeCalls
from homebot.bridges.home_api.routes import ApiRoute
from homebot.bridges.home_api.shapes import (
    Answer,
    NoQuestion,
    OutcomeAnswer,
    PrintableText,
    ProblemError,
    Question,
    ShortName,
)
from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.outcomes import AlreadySo
from homebot.devices.scene_messages import ScenesResponse
from homebot.features.scenes import APPLY_SCENE, LIST_SCENES
from homebot.support.printable import printable

_WIDEST: Final = 100


class SceneQuestion(Question):
    """A scene by its name or id; with `undo`, the values before it are brought back."""

    scene: ShortName
    undo: bool = False
    transition: Annotated[float, Field(ge=0.0, le=86_400.0)] = 0.0


class SceneLine(Answer):
    """A scene, with the values of its parts by name; a part without values has those of the bridge that keeps it."""

    scene: PrintableText
    id: str = ""
    room: str = ""
    parts: dict[str, PrintableText] = {}  # noqa: RUF012 - pydantic copies it


class SceneList(Answer):
    """The scenes of the house."""

    scenes: tuple[SceneLine, ...]


async def list_scenes(home: HomeCalls, _: NoQuestion) -> SceneList:
    """Return the scenes: those of the owner, and those that bridges keep, of which several may have one name."""
    answer = cast("ScenesResponse", await call_or_fail(home, LIST_SCENES.name, {}))
    lines = (
        SceneLine(
            scene=scene.name,
            id=scene.id if scene.is_native else "",
            room=scene.area,
            parts={printable(part.name, _WIDEST): part.text for part in scene.parts},
        )
        for scene in answer.scenes
    )
    return SceneList(scenes=tuple(lines))


async def apply_scene(home: HomeCalls, asked: SceneQuestion) -> OutcomeAnswer:
    """Apply a scene, or bring back the values before it, and return the worst outcome with that of each part."""
    request = {"name": asked.scene, "undo": asked.undo, "transition": asked.transition}
    answer = cast("CommandDevicesResponse", await home.call(APPLY_SCENE.name, request))
    if answer.results:
        return outcome_of(answer, asked.scene, lambda one: printable(one.name, _WIDEST))
    if answer.success:
        return OutcomeAnswer(id=asked.scene, outcome=AlreadySo.kind, text=answer.message)
    raise ProblemError(HTTPStatus.NOT_FOUND, answer.message)


ROUTES: Final = (
    ApiRoute("GET", "/api/scenes", NoQuestion, SceneList, list_scenes),
    ApiRoute("POST", "/api/scene", SceneQuestion, OutcomeAnswer, apply_scene),
)
