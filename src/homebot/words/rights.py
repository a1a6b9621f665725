"""Rights in the owner's words: ``read``, ``act: light in hall``, ``ask: lock``. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Final

from homebot.devices.client_rights import ALL_ROBOTS, HARMLESS, LOCAL_RIGHTS, ORDINARY, ClientRights
from homebot.devices.query.terms import Query
from homebot.devices.robot_owners import check_robot_name
from homebot.errors import InvalidNameError, UsageError
from homebot.rights import Right
from homebot.support.names import did_you_mean
from homebot.words.exact_queries import parse_exact_query

_ALL: Final = "all"
_KNOWN: Final = (
    "known are read, act: QUERY, act: harmless, act: ordinary, act: all, ask: QUERY, ask: all, manage, raw, robot: NAME"
)
_WORDS: Final = frozenset({HARMLESS, ORDINARY, _ALL})
_NEEDS: Final = {
    Right.ACT: "needs a query, or all: 'act: light in hall'",
    Right.ASK: "needs a query, or all: 'ask: lock in hall'",
    Right.ROBOT: "needs the name of a robot: 'robot: rosie'",
}


def read_scope(scope: Iterable[str]) -> ClientRights:
    """Return the rights that *scope* lists.

    Raises:
        UsageError: One entry is not a right; the message names it and an example.
    """
    found: dict[Right, list[str]] = {}
    for text in scope:
        right, query = _read_right(text)
        found.setdefault(right, []).append(query)
    wanted, asked = found.get(Right.ACT, []), found.get(Right.ASK, [])
    return ClientRights(
        kinds=frozenset(found) | ({Right.ACT} if asked else frozenset()),
        acts_on=tuple(_parse(query) for query in wanted if query not in _WORDS),
        acts_on_harmless=not _WORDS.isdisjoint(wanted),
        acts_on_ordinary=ORDINARY in wanted or _ALL in wanted,
        acts_on_all=_ALL in wanted,
        asks_on=tuple(_parse(query, "ask") for query in asked if query != _ALL),
        asks_on_all=_ALL in asked,
        act_scope=(*(f"act: {query}" for query in wanted), *(f"ask: {query}" for query in asked)),
        robots=tuple(found.get(Right.ROBOT, ())),
    )


@lru_cache(maxsize=256)
def rights_of(scope: tuple[str, ...]) -> ClientRights:
    """Return the rights to devices of a client with *scope*, which is empty without a token, as :func:`read_scope`."""
    return read_scope(scope) if scope else LOCAL_RIGHTS


def patterns_of_rights(scopes: Mapping[str, Iterable[str]]) -> Iterator[tuple[str, str, Query]]:
    """Yield the key, the right and the terms of each query of the rights in *scopes*, which are by key."""
    for key, scope in scopes.items():
        for right in scope:
            rights = read_scope((right,))
            yield from ((key, right, query) for query in rights.acts_on + rights.asks_on)


def _read_right(text: str) -> tuple[Right, str]:
    word, _, query = (one.strip() for one in text.partition(":"))
    right = next((one for one in Right if one.value == word), None)
    if right is None:
        hint = did_you_mean(word or "?", [one.value for one in Right], _KNOWN)
        raise UsageError(f"{text!r} is not a right; {hint}")
    if bool(query) is not (right in _NEEDS):
        raise UsageError(f"{text!r}: {word} {_NEEDS.get(right, 'takes no query')}")
    if right is Right.ROBOT and query != ALL_ROBOTS:
        try:
            check_robot_name(query)
        except InvalidNameError as exc:
            raise UsageError(f"{text!r}: {exc}") from exc
    return right, query


def _parse(text: str, right: str = "act") -> Query:
    try:
        return parse_exact_query(text)
    except UsageError as exc:
        raise UsageError(f"'{right}: {text}': {exc}") from exc
