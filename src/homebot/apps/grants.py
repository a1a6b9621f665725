"""The key ``act`` in tables of the configuration: the devices that an app may command."""

from collections.abc import Iterator

from homebot.config import Config, Table
from homebot.errors import ConfigError, UsageError

ACT = "act"
"""The key for the devices that an app may command, and for whether a gateway sends commands at all."""


def grants_of(config: Config) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield each node that has grants, with its grants.

    Raises:
        ConfigError: The grants of a table are wrong.
    """
    for name, table in config.apps.items():
        if (scope := scope_of(f"apps.{name}", table, config.source)) is not None:
            yield f"/{name}", scope


def scope_of(key: str, table: Table, source: str) -> tuple[str, ...] | None:
    """Return the grants of the table *key*; None if it has none.

    Raises:
        ConfigError: They are wrong.
    """
    if (act := table.get(ACT)) is None:
        return None
    from homebot.words.rights import read_scope  # noqa: PLC0415 - few apps have a scope

    key, queries = f"{key}.{ACT}", [act] if isinstance(act, str) else act
    if not isinstance(queries, list) or not all(isinstance(query, str) for query in queries):
        raise ConfigError(source, key, f"must be a query such as 'light in hall', or several, got {act!r}")
    scope = tuple(f"act: {query}" for query in queries) or ("read",)
    try:
        read_scope(scope)
    except UsageError as exc:
        raise ConfigError(source, key, str(exc)) from exc
    return scope


def queries_of(scope: tuple[str, ...]) -> tuple[str, ...]:
    """Return the value of the key for *scope*."""
    return tuple(line.removeprefix("act: ") for line in scope if line != "read")


def without_act(table: Table) -> Table:
    """Return *table* without the key."""
    return {key: value for key, value in table.items() if key != ACT}
