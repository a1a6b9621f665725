"""The secrets in a configuration, as the readers of its tables declare them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from homebot.config import Config
from homebot.runtime.plan import plan_errors
from homebot.support.key_roles import DeclaredKey, KeyRole, declared_keys, has_password, role_by_name, tables_read


class SecretsOfFile(NamedTuple):
    """The secrets in a file.

    Attributes:
        texts: Those that stand in it.
        files: The files with secrets that it names, as it names them.
    """

    texts: frozenset[str]
    files: frozenset[str]


def keys_of_tables(config: Config) -> tuple[tuple[DeclaredKey, ...], ...]:
    """Return the values of each table of *config*, also with mistakes, but not of plug-ins that are missing."""
    with tables_read() as tables:
        plan_errors(config)
    return tuple(tuple(declared_keys(model, table, tuple(key.split(".")))) for key, model, table in tables)


def secrets_of(config: Config, tables: Mapping[str, object]) -> SecretsOfFile:
    """Return the secrets in *tables*, which *config* was read from.

    Passwords in URLs are secrets, too, and texts with the name of one in tables without a reader.
    """
    roles = [(key.role, key.value) for table in keys_of_tables(config) for key in table]
    known = {value for _, value in roles}
    for name, value in texts_of(tables):
        role = KeyRole.PUBLIC if value in known else role_by_name(name)
        roles.append((KeyRole.SECRET if has_password(value) else role, value))
    texts, files = (
        frozenset(value for role, value in roles if role is wanted) for wanted in (KeyRole.SECRET, KeyRole.SECRET_FILE)
    )
    return SecretsOfFile(texts, files)


def texts_of(tables: object, key: str = "") -> Iterator[tuple[str, str]]:
    """Yield each text in *tables* with its key."""
    if isinstance(tables, Mapping):
        for name, value in tables.items():
            yield from texts_of(value, name)
    elif isinstance(tables, list):
        for value in tables:
            yield from texts_of(value, key)
    elif isinstance(tables, str):
        yield key, tables
