"""The gallery: ready-made routines with inputs, in the folder ``ready_made``.

Its ``texts.json`` has the texts that no grammar reads, and the defaults, in the languages of :data:`COLUMNS`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from shlex import quote
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field, model_validator

from homebot.config import parse_settings
from homebot.errors import UsageError
from homebot.features.routines.messages import ReadyMadeInput, ReadyMadeRoutine
from homebot.support.names import resolve_name
from homebot.support.toml_file import parse_toml
from homebot.words.mistakes import COLUMNS
from homebot.words.own_language import TextKind, in_language
from homebot.words.routine_text import routine_text

_FOLDER: Final = files(__package__) / "ready_made"
_KINDS: Final[Mapping[str, TextKind]] = {"when": "trigger", "if": "condition", "while": "condition", "do": "step"}


class GalleryInput(BaseModel):
    """A device or value that a ready-made routine asks for.

    Attributes:
        find: The devices to choose from, as for ``homebot find``; empty for a value.
        default: The value unless another is stated.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    find: str = ""
    default: str = ""


class GalleryRoutine(BaseModel):
    """A ready-made routine, in whose texts ``<key>`` stands for an input.

    Attributes:
        about: The purpose, in one sentence.
        inputs: By their keys.
        routine: Its table.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    about: Annotated[str, Field(min_length=1)]
    inputs: Mapping[str, GalleryInput] = {}
    routine: Mapping[str, object]

    @model_validator(mode="after")
    def _check_that_each_input_is_used(self) -> GalleryRoutine:
        text = repr(self.routine)
        if unused := [key for key in self.inputs if f"<{key}>" not in text]:
            raise ValueError(f"inputs.{unused[0]}: the routine does not use it")
        return self

    def filled(self, said: Mapping[str, str], language: str = "") -> str:
        """Return the routine as text, in *language*.

        Args:
            said: The inputs by their keys; inputs with a default may be left out.

        Raises:
            UsageError: An input is missing or unknown.
        """
        stated = {resolve_name("input", key, self.inputs): value.strip() for key, value in said.items()}
        values = {key: stated.get(key) or text_in(language, one.default) for key, one in self.inputs.items()}
        if missing := [key for key, value in values.items() if not value]:
            devices = self.inputs[missing[0]].find
            raise UsageError(f"say which: {missing[0]}=NAME; `homebot find {quote(devices)}` lists what fits")
        spoken = {key: value.strip("'\"") for key, value in values.items()}

        def fill(key: str, text: str) -> str:
            own = text_in(language, text)
            for name, value in (spoken if key == "name" or text.startswith("notify ") else values).items():
                own = own.replace(f"<{name}>", value)
            return in_language(own, _KINDS[key], language) if key in _KINDS else own

        return routine_text({key: _filled(key, value, fill) for key, value in self.routine.items()})


@cache
def gallery() -> Mapping[str, GalleryRoutine]:
    """Return the ready-made routines by their names, sorted."""
    names = sorted(one.name.removesuffix(".toml") for one in _FOLDER.iterdir() if one.name.endswith(".toml"))
    return {name: _read(name) for name in names}


def ready_made(name: str) -> GalleryRoutine:
    """Return the ready-made routine *name*.

    Raises:
        UsageError: There is none; the message has the nearest name.
    """
    return gallery()[resolve_name("ready-made routine", name, gallery(), "`homebot routine gallery` lists them")]


def listed(language: str) -> tuple[ReadyMadeRoutine, ...]:
    """Return the gallery for clients, with its texts in *language*."""
    return tuple(
        ReadyMadeRoutine(
            name=name,
            about=text_in(language, one.about),
            inputs=tuple(
                ReadyMadeInput(
                    key=key,
                    label=text_in(language, key.replace("_", " ")),
                    find=own.find,
                    default=text_in(language, own.default),
                )
                for key, own in one.inputs.items()
            ),
        )
        for name, one in gallery().items()
    )


def text_in(language: str, text: str) -> str:
    """Return the English *text* of the gallery in *language*; as it is if it is the same there."""
    own = _texts().get(text)
    return own[COLUMNS.index(language)] if own and language in COLUMNS else text


@cache
def _texts() -> Mapping[str, Sequence[str]]:
    texts: dict[str, list[str]] = json.loads((_FOLDER / "texts.json").read_text("utf-8"))
    return texts


def _read(name: str) -> GalleryRoutine:
    source = f"{name}.toml"
    return parse_settings(GalleryRoutine, parse_toml((_FOLDER / source).read_text("utf-8"), source), source, "")


def _filled(key: str, value: object, fill: Callable[[str, str], str]) -> object:
    match value:
        case str():
            return fill(key, value)
        case list():
            return [_filled(key, one, fill) for one in value]
        case dict():
            return {inner: _filled(inner, one, fill) for inner, one in value.items()}
        case _:
            return value
