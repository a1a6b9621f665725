"""Routines as text: tables ``[[routines]]``. Pure."""

import re
from collections.abc import Iterable
from contextlib import suppress
from functools import partial
from typing import Final, NamedTuple

from homebot.apps.grants import ACT, scope_of, without_act
from homebot.config import Table, parse_config, parse_settings, read_all
from homebot.config_lines import located
from homebot.devices.client_rights import ORDINARY
from homebot.errors import ConfigError
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.tables import check_routine_name
from homebot.support.toml_file import parse_toml
from homebot.support.toml_text import toml_value
from homebot.words.routine_text import routine_text

_HEAD: Final = re.compile(r"^(?=[ \t]*\[\[\s*routines\s*\]\])", re.MULTILINE)
_ACT: Final = re.compile(rf"^[ \t]*{ACT}[ \t]*=.*$", re.MULTILINE)


class WrittenRoutine(NamedTuple):
    """A routine as it was written.

    Attributes:
        app: The name of its node.
        text: Its table, with the comments in it.
    """

    app: str
    name: str
    table: Table
    text: str


def read_routines(text: str, source: str) -> tuple[WrittenRoutine, ...]:
    """Return the routines in *text*: tables ``[[routines]]``, or the keys of one.

    Raises:
        ConfigError: It has none, has other tables, or mistakes; each is named, with its line.
    """
    if is_bare := "name" in (tables := parse_toml(text, source)):
        tables, text = {"routines": [tables]}, f"[[routines]]\n{text}"
    if others := tables.keys() - {"routines"}:
        raise ConfigError(source, min(others), "is no part of a routine; write [[routines]], name, when, if and do")
    apps = parse_config(tables, source).apps
    if not apps:
        raise ConfigError(source, "", "has no table [[routines]]")
    head, *rest = _HEAD.split(text)
    texts = [f"{head}{rest[0]}", *rest[1:]] if rest else [head]
    if len(texts) != len(apps):
        raise ConfigError(
            source, "routines", "must be written as tables with the head [[routines]] in a line of its own"
        )
    try:
        return tuple(read_all(map(partial(partial, _checked, source), apps, apps.values(), texts)))
    except ConfigError as exc:
        raise (exc if is_bare else located(exc, text)) from None


def read_settings(text: str, source: str) -> RoutineSettings:
    """Return the only routine in *text*.

    Raises:
        ConfigError: As :func:`read_routines`.
    """
    (routine,) = read_routines(text, source)
    return parse_settings(RoutineSettings, without_act(routine.table), source, f"routines.{routine.app}")


def acts_on(table: Table) -> list[str]:
    """Return the queries of the key ``act`` of the routine *table*, by default for all that does not always ask."""
    act = table.get(ACT, ORDINARY)
    return [str(query) for query in (act if isinstance(act, list) else [act])]


def with_act(routine: WrittenRoutine, queries: Iterable[str]) -> str:
    """Return the text of *routine* with *queries* added to its key ``act``."""
    table = {**routine.table, ACT: list(dict.fromkeys((*acts_on(routine.table), *queries)))}
    line = f"{ACT} = {toml_value(table[ACT])}"
    text = _ACT.sub(lambda _: line, routine.text, 1) if ACT in routine.table else f"{routine.text}{line}\n"
    with suppress(ConfigError):
        if parse_config(parse_toml(text, ""), "").apps == {routine.app: table}:
            return text
    return routine_text({key: value for key, value in table.items() if key != "class"})  # without its comments


def _checked(source: str, app: str, table: Table, text: str) -> WrittenRoutine:
    check_routine_name(app, table, source)
    scope_of(f"routines.{app}", table, source)
    name = parse_settings(RoutineSettings, without_act(table), source, f"routines.{app}").name
    return WrittenRoutine(app, name, table, f"{text.strip()}\n")
