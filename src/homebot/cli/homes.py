"""The user's homes by name, in ``homes.toml`` of the user's configuration folder.

::

    [villa]
    door = "192.168.1.10:9090"
    token_file = "villa.token"       # beside this file
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

from homebot.cli.arguments import door_address
from homebot.errors import ConfigError
from homebot.support.file_access import why_not_trusted
from homebot.support.similar import did_you_mean, unknown_key
from homebot.support.toml_file import TomlTable, read_toml

__all__ = ["NamedHome", "homes_file", "named_home"]

_EXAMPLE = 'write a table [{name}] with door = "HOST:PORT" and, if it needs one, token_file = "FILE"'


class NamedHome(NamedTuple):
    """A home of the file.

    Attributes:
        token_file: File with its token; None for none.
    """

    host: str
    port: int
    token_file: Path | None


def homes_file() -> Path:
    """Return the path of the file, which may not exist."""
    from platformdirs import user_config_path  # noqa: PLC0415 - only with --home

    return user_config_path("homebot", appauthor=False) / "homes.toml"


def named_home(name: str) -> NamedHome:
    """Return the home *name*.

    Raises:
        ConfigError: The file does not have it, cannot be used, or may be changed by other users.
    """
    path = homes_file()
    source, example = str(path), _EXAMPLE.format(name=name)
    if not path.exists():
        raise ConfigError(source, "", f"does not exist; {example}")
    homes = read_toml(path)
    if problem := why_not_trusted(path):
        raise ConfigError(source, "", f"says where homes are, so others must not be able to change it: {problem}")
    if name not in homes:
        raise ConfigError(source, name, f"there is no such home; {did_you_mean(name, homes, example)}")
    table = homes[name]
    if not isinstance(table, dict) or not isinstance(table.get("door"), str):
        raise ConfigError(source, name, f"names no address; {example}")
    return _home_in(table, name, path)


def _home_in(table: TomlTable, name: str, path: Path) -> NamedHome:
    source, file = str(path), table.get("token_file")
    for key in table.keys() - {"door", "token_file"}:
        raise ConfigError(source, f"{name}.{key}", unknown_key(key, ("door", "token_file")))
    try:
        host, port = door_address(str(table["door"]))
    except argparse.ArgumentTypeError as exc:
        raise ConfigError(source, f"{name}.door", str(exc)) from exc
    if file is not None and not isinstance(file, str):
        raise ConfigError(source, f"{name}.token_file", f"must be a text in quotes, got {file!r}")
    return NamedHome(host, port, path.parent / file if file else None)
