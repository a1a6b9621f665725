"""Tables ``[[routines]]``, each of which is an app, and the lines of mistakes in a configuration."""

import tomllib
from collections.abc import Container, Mapping
from contextlib import suppress
from pathlib import Path
from zlib import crc32

from homebot.errors import ConfigError
from homebot.support.folding import words_of
from homebot.support.toml_lines import line_of

__all__ = ["app_of_routine", "apps_of_routines", "check_routine_name", "located"]

_LONGEST_APP = 100
_UNNAMED = "routine"


def apps_of_routines(routines: object, taken: Container[str]) -> dict[str, dict[str, object]]:
    """Return the tables of *routines* by the names of their apps: those of the routines in small letters.

    One without a name, or with that of another or one of *taken*, has its number in its name, and is reported with its
    values.
    """
    found: dict[str, dict[str, object]] = {}
    for number, table in enumerate(routines if isinstance(routines, list) else [routines], 1):
        fields = table if isinstance(table, dict) else {}
        app = app_of_routine(fields.get("name"))
        is_new = app and app not in taken and app not in found
        found[app if is_new else f"{app or _UNNAMED}_{number}"] = fields
    return found


def app_of_routine(name: object) -> str:
    """Return the name of the app of the routine *name*; empty if that is no name."""
    if not isinstance(name, str) or not name.strip():
        return ""
    app = "_".join(words_of(name))[:_LONGEST_APP]
    if not app or not app.isascii():  # names of nodes have only Latin letters
        return f"{_UNNAMED}_{crc32(name.encode()):x}"
    return app if app[0].isalpha() else f"{_UNNAMED}_{app}"


def check_routine_name(app: str, table: Mapping[str, object], source: str) -> None:
    """Check that the routine *table* has a name, which no other routine or app has.

    Args:
        app: The name of its app.

    Raises:
        ConfigError: It has none, or that of another.
    """
    name = table.get("name")
    if (expected := app_of_routine(name)) != app:
        problem = f"{name!r} is also the name of another routine or app; choose another one"
        reason = problem if expected else f"must be a name, such as 'Hall light', got {name!r}"
        raise ConfigError(source, f"routines.{app}.name", reason)


def located(error: ConfigError, text: str = "") -> ConfigError:
    """Return *error* with the line of its key in *text*, by default that of its file; the same if it is unknown."""
    path = error.key.split(".")
    with suppress(OSError, ValueError, RecursionError):
        text = text or Path(error.source).read_text("utf-8-sig")
        if path[0] == "routines":  # they are named by their apps
            tables = tomllib.loads(text)
            apps = [*apps_of_routines(tables.get("routines", []), tables.get("apps", {}))]
            path[1:2] = [str(apps.index(one)) for one in path[1:2]]
    line = line_of(text, *path)
    found = ConfigError(f"{error.source}:{line}" if line else error.source, error.key, error.reason)
    return ConfigError.joined((found, *(located(one, text) for one in error.others)))
