"""Wrong routines, groups and tables of features in a configuration, which stop nothing else. Pure."""

from collections.abc import Callable, Mapping
from functools import partial

from homebot.apps.grants import ACT
from homebot.config import Config
from homebot.config_lines import located
from homebot.errors import ConfigError
from homebot.support.folding import fold


def without_mistakes(
    config: Config, planned: Mapping[str, Callable[[], object]], readers: Mapping[str, Callable[[Config], object]]
) -> tuple[Config, dict[str, ConfigError]]:
    """Return *config* without its wrong routines, groups and arrays of features, and their mistakes by key.

    A group that a policy or right names is kept, because without it a limit would be gone.

    Args:
        planned: Calls that raise the mistake of each app of a table of a feature, by its key.
        readers: Readers of lists of tables, which raise the first mistake, by the names of the lists.
    """
    wrong: dict[str, ConfigError] = {}
    for key, plan in planned.items():
        if (error := _mistake_in(plan)) is not None:
            wrong[key] = located(error)
    gone = {key.partition(".")[2] for key in wrong}
    apps = {name: table for name, table in config.apps.items() if name not in gone}
    config = config.model_copy(update={"apps": apps})
    limits = _words_in(repr((config.control, config.door, [table.get(ACT) for table in config.apps.values()])))
    for kind, read in readers.items():
        while (error := _mistake_in(partial(read, config))) is not None:
            if error.key == kind:  # it is of no feature
                wrong[kind] = located(error)
                config = _with_tables(config, kind, None)
                break
            tables: list[object] = [*(config.groups if kind == "groups" else config.array_of(kind))]
            number = error.key.partition(".")[2].partition(".")[0]
            place = int(number) if number else max(at for at, table in enumerate(tables) if table is not None)
            if kind == "groups" and _is_named(tables[place], limits):
                break
            wrong[f"{kind}.{place}"], tables[place] = located(error), None
            config = _with_tables(config, kind, tuple(tables))
    return config, wrong


def _with_tables(config: Config, kind: str, tables: tuple[object, ...] | None) -> Config:
    """Return *config* with other groups or tables of a feature; None for no such table."""
    if kind == "groups":
        return config.model_copy(update={"groups": tables or ()})
    others = {key: table for key, table in config.features.items() if key != kind}
    return config.model_copy(update={"features": others if tables is None else {**others, kind: tables}})


def _is_named(group: object, limits: str) -> bool:
    name = group.get("name") if isinstance(group, dict) else None
    return isinstance(name, str) and _words_in(name) in limits


def _words_in(text: str) -> str:
    """Return the folded words of *text*, each between blanks."""
    words = "".join(character if character.isalnum() else " " for character in text).split()
    return f" {' '.join(map(fold, words))} "


def _mistake_in(read: Callable[[], object]) -> ConfigError | None:
    try:
        read()
    except ConfigError as exc:
        return exc
    return None
