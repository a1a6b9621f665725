"""The lines of mistakes in a configuration."""

import tomllib
from contextlib import suppress
from pathlib import Path

from homebot.errors import ConfigError
from homebot.feature import feature_tables, load
from homebot.support.toml_lines import line_of


def located(error: ConfigError, text: str = "") -> ConfigError:
    """Return *error* with the line of its key in *text*, by default that of its file; the same if it is unknown."""
    path = error.key.split(".")
    with suppress(OSError, ValueError, RecursionError):
        text = text or Path(error.source).read_text("utf-8-sig")
        if (row := feature_tables().get(path[0])) is not None and row.plugin and row.is_array:
            tables = tomllib.loads(text)  # they are named by their apps
            apps = [*load(row.reader)(tables.get(path[0], []), tables.get(row.section, {}))]
            path[1:2] = [str(apps.index(one)) for one in path[1:2]]
    line = line_of(text, *path)
    config_error = ConfigError(f"{error.source}:{line}" if line else error.source, error.key, error.reason)
    return ConfigError.joined((config_error, *(located(one, text) for one in error.others)))
