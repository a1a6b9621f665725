"""The tables ``[[scenes]]``. Pure."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from homebot.config import Config, parse_settings, value_errors
from homebot.devices.scene_messages import MAX_PARTS
from homebot.errors import ConfigError, UsageError
from homebot.features.scenes.scene_book import check_scene_name
from homebot.support.folding import fold
from homebot.words.commands import check_without_code

_Words = Annotated[str, Field(min_length=1, max_length=1000)]


def _without_code(words: str) -> str:
    with value_errors():
        check_without_code(words)
    return words


_Values = Annotated[
    dict[_Words, Annotated[_Words, AfterValidator(_without_code)]], Field(min_length=1, max_length=MAX_PARTS)
]


class SceneSettings(BaseModel):
    """A table ``[[scenes]]``.

    Attributes:
        name: Its name for people.
        values: Devices or queries, each with its values in the words of ``homebot do``, such as ``on, 20 %``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    name: str
    values: _Values


def read_scenes(config: Config) -> tuple[SceneSettings, ...]:
    """Return the scenes in the tables ``[[scenes]]``; their devices may come later.

    Raises:
        ConfigError: A name or a value is missing, wrong or given twice; the message names the key.
    """
    source = config.source
    scenes: dict[str, SceneSettings] = {}
    for number, table in enumerate(config.array_of("scenes")):
        if table is None:
            continue
        scene = parse_settings(SceneSettings, table, source, f"scenes.{number}")
        try:
            check_scene_name(scene.name)
        except UsageError as exc:
            raise ConfigError(source, f"scenes.{number}.name", str(exc)) from exc
        if fold(scene.name) in scenes:
            raise ConfigError(source, f"scenes.{number}.name", f"there is a scene {scene.name!r} already")
        scenes[fold(scene.name)] = scene
    return tuple(scenes.values())
