"""The lines of mistakes in a configuration."""

import re
import tomllib
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from homebot.errors import ConfigError
from homebot.feature import feature_tables, load
from homebot.support.toml_lines import line_of

_LANGUAGE: Final = re.compile(r"""^[ \t]*language[ \t]*=[ \t]*["'](\w\w)["']""", re.MULTILINE)


def located(error: ConfigError, text: str = "") -> ConfigError:
    """Return *error* with the line of its key in *text*, by default that of its file, and as its house says it."""
    from homebot.words.mistakes import mistake_in  # noqa: PLC0415 - after a mistake alone

    path = error.key.split(".")
    with suppress(OSError, ValueError, RecursionError):
        text = text or Path(error.source).read_text("utf-8-sig")
        if (row := feature_tables().get(path[0])) is not None and row.plugin and row.is_array:
            path[1:2] = [str(_apps_in(text, path[0]).index(app)) for app in path[1:2]]
    line, reason = line_of(text, *path), mistake_in(language_in(text), error.reason)
    config_error = ConfigError(f"{error.source}:{line}" if line else error.source, error.key, reason)
    return ConfigError.joined((config_error, *(located(other, text) for other in error.others)))


@lru_cache(maxsize=1)  # the mistakes in a file follow each other
def _tables(text: str) -> dict[str, Any]:
    return tomllib.loads(text)


def language_in(text: str) -> str:
    """Return the language of the house in *text*, which may be no TOML; empty if it says none."""
    with suppress(LookupError, TypeError, ValueError, RecursionError):
        return str(_tables(text)["home"]["language"])
    found = _LANGUAGE.search(text)
    return found[1] if found else ""


@lru_cache(maxsize=1)  # as above
def _apps_in(text: str, key: str) -> tuple[str, ...]:
    """Return the names of the apps of the array *key* of a feature in *text*, in order."""
    row, tables = feature_tables()[key], _tables(text)
    return tuple(load(row.reader)(tables.get(key, []), tables.get(row.section, {})))
