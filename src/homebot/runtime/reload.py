"""Reloading of the configuration: tokens, rights, policies, places and the way of notifications change at once.

A file that is half saved lacks limits, so a reload may lose none, nor a whole table, unless the user means it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

from anyio import to_thread
from pydantic import SecretStr

from homebot.apps.grants import ACT
from homebot.bridges.rosbridge import RosbridgeServer
from homebot.config import Config
from homebot.control import Control
from homebot.control.settings import PolicySettings
from homebot.devices.app_messages import ChangeAppResponse
from homebot.devices.client_rights import ALL_ROBOTS, NodeGrants
from homebot.discovery import Directory
from homebot.discovery.house_rooms import HouseRooms
from homebot.errors import ConfigError, UsageError
from homebot.feature import feature_tables
from homebot.runtime.plan import Plan
from homebot.support.logger import get_logger

RELOADED = "runtime.reloaded"

_log = get_logger(node="/homebot")

_SECTIONS: Final = ("gateways", "apps", "robots")
"""The keys that contain tables by name."""

_TOKEN: Final = frozenset({"token", "token_file"})
_LIVE: Final[Mapping[str, frozenset[str]]] = {
    "door": _TOKEN | {"tokens", "scope"},
    "control": frozenset(PolicySettings.model_fields),
    "apps": frozenset({ACT}),
    "devices": frozenset({"limits"}),
    "home": frozenset({"id"}),
    "ros": frozenset({"ca", "cert_file", "connect", "domain", "export", "import", "key_file", "listen", "user"}),
}
"""The keys that take effect without a restart, as do places, devices, groups, ``notify`` and tables that are live."""

_RELOADED: Final = ("config", "door", "control", "places", "limits", "link", "notify", "features", "left_out")
"""The parts of a plan that a reload replaces."""

_BY_KEY: Final = frozenset({"control", "door"})
"""Tables of which only live keys are missed."""

_LOST: Final = "save it whole, or if you mean it: homebot reload --allow-removal, or restart homebot"

_LONG: Final = 16
"""Characters of a token too long to guess."""


class RunningParts(NamedTuple):
    """The running components to update.

    Attributes:
        server: Returns the rosbridge server; None before it listens.
        control: None before it runs.
        directory: None before it runs.
        granted: Returns grants with those of the apps that features keep.
    """

    server: Callable[[], RosbridgeServer | None]
    control: Control | None
    directory: Directory | None
    granted: Callable[[NodeGrants], NodeGrants]


def keys_for_restart(before: Config, after: Config) -> tuple[str, ...]:
    """Return the keys that differ and take effect at the next start."""
    live = {"places", "devices", "groups", "notify", *(key for key, table in feature_tables().items() if table.is_live)}
    old, new = ({key: table for key, table in _by_key(config).items() if key not in live} for config in (before, after))
    keys = (key for table in old | new for key in _find_changes(table, old.get(table) or {}, new.get(table) or {}))
    robots = sorted(_robots(new["door"]) - _robots(old["door"]) - {ALL_ROBOTS, *old["robots"], *new["robots"]})
    return (*keys, *(f"door.tokens (the robot {name})" for name in robots))


def _robots(table: Mapping[str, Any]) -> set[str]:
    """Return the names of the robots that tokens may act as, which are tracked from the start."""
    from homebot.words.rights import read_scope  # noqa: PLC0415 - few have a scope

    return {name for token in table.get("tokens", {}).values() for name in read_scope(token.get("scope", ())).robots}


def _find_changes(table: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[str]:
    for key in dict.fromkeys((*old, *new)):
        if old.get(key) == new.get(key) or (key in _LIVE.get(table, ()) and _runs(table, old)):
            continue
        if table in _SECTIONS and key in old and key in new:
            rest = (setting for setting in dict.fromkeys((*old[key], *new[key])) if setting not in _LIVE.get(table, ()))
            yield from (
                f"{table}.{key}.{setting}" for setting in rest if old[key].get(setting) != new[key].get(setting)
            )
        else:
            yield f"{table}.{key}"


def _runs(table: str, old: Mapping[str, Any]) -> bool:
    """Return whether what the live keys of *table* are for was there at the start."""
    return table != "ros" or not old.keys().isdisjoint(("connect", "listen"))


def lost_keys(before: Config, after: Config) -> tuple[str, ...]:
    """Return the tables of *before* that *after* lacks, and the keys that limit what somebody may do.

    A token may go while others stay, as it is revoked so; a key of a place, unless half a file might end there.
    """
    return tuple(_lost(_by_key(before), _by_key(after)))


def _by_key(config: Config) -> dict[str, Any]:
    """Return the tables of *config* by the keys that they have in the file."""
    tables: dict[str, Any] = config.model_dump()
    features: dict[str, Any] = tables.pop("features")
    return tables | features


def _lost(old: Mapping[str, Any], new: Mapping[str, Any], *path: str, is_last: bool = True) -> Iterator[str]:
    for key, value in old.items():
        here, other = (*path, key), new.get(key)
        if _is_empty(value) or (not other and _is_revoked(here, new)):
            continue
        if tables := _tables_in(value):
            yield from _lost_tables(tables, other, here, is_last=key in [*new][-1:])
        elif other is None and _is_limit(here) and (is_last or here[0] != "places"):
            yield ".".join(here)


def _lost_tables(
    tables: Sequence[Mapping[str, Any]], other: object, here: tuple[str, ...], *, is_last: bool
) -> Iterator[str]:
    left = _tables_in(other)
    is_gone = other in (None, {}) or 0 < len(left) < len(tables)
    if is_gone and (here[0] not in _BY_KEY or _is_limit(here)):
        yield f"[{'.'.join(here)}]"
        return
    for old_table, its_new in zip(tables, left, strict=False):
        yield from _lost(old_table, its_new, *here, is_last=is_last)


def _is_revoked(path: tuple[str, ...], new: Mapping[str, Any]) -> bool:
    """Return whether the key *path* may be gone because it is a token, or all of them, and *new* has another."""
    if path[:2] == ("door", "tokens") and len(path) == len(("door", "tokens", "NAME")):
        return True
    return bool(new.keys() & _TOKEN) and (path == ("door", "tokens") or path[-1] in _TOKEN)


def _is_empty(value: object) -> bool:
    return value is None or value is False or (isinstance(value, Mapping) and all(map(_is_empty, value.values())))


def _tables_in(value: object) -> list[Mapping[str, Any]]:
    """Return *value* if it is a table, or the tables of an array."""
    return [item for item in (value if isinstance(value, list) else [value]) if isinstance(item, Mapping)]


def _is_limit(path: tuple[str, ...]) -> bool:
    return path[0] == "places" or (path[0] != "ros" and not _LIVE.get(path[0], frozenset()).isdisjoint(path))


def _cut_tokens(before: Mapping[str, SecretStr], after: Mapping[str, SecretStr]) -> Iterator[str]:
    """Yield the tokens whose files may be half written."""
    for name, token in after.items():
        old, new = before.get(name, token).get_secret_value(), token.get_secret_value()
        if new != old and (old.startswith(new) or len(new) < min(len(old), _LONG)):
            yield f"the end of the token {name}"


async def _apply(new: Plan, plan: Plan, parts: RunningParts, granted: NodeGrants, rooms: HouseRooms | None) -> None:
    if (server := parts.server()) is not None:
        server.update_tokens(new.door)
    plan.grants.now = granted
    needs_approval = parts.control is None or parts.control.update_policies(new.control)
    if parts.directory is not None and rooms is not None:
        parts.directory.index.postings.needs_approval = needs_approval
        parts.directory.index.table.limits = new.limits
        if new.places != plan.places:
            await parts.directory.reconfigure(new.places, rooms)


async def reload_configuration(
    running: Config,
    plan: Plan,
    parts: RunningParts,
    read: Callable[[], Config],
    make_plan: Callable[[Config], Plan],
    *,
    may_lose: bool,
) -> tuple[Plan, ChangeAppResponse]:
    """Apply the changes in the configuration from *read* that need no restart; if it has a mistake, change nothing.

    Args:
        read: Called in a worker thread.
        make_plan: Called in a worker thread, with the result of *read*.
        may_lose: Whether it may lack tables, tokens, rights, policies and places of *plan*.
    """
    try:
        config = await to_thread.run_sync(read)
        new = await to_thread.run_sync(make_plan, config)
        lost = () if may_lose else (*lost_keys(plan.config, new.config), *_cut_tokens(plan.tokens, new.tokens))
        if lost:
            raise ConfigError(config.source, "", f"lacks what it had before: {', '.join(lost)}; {_LOST}")
        granted = parts.granted(new.grants.now)
        rooms = None if parts.directory is None else parts.directory.index.owner.rooms.reconfigured(new.places)
    except UsageError as exc:
        _log.error(RELOADED, message=f"nothing was reloaded: {exc}")
        return plan, ChangeAppResponse(success=False, message=str(exc))
    await _apply(new, plan, parts, granted, rooms)
    waiting = ", ".join(keys_for_restart(running, config))
    rest = f"; restart homebot for the changes of {waiting}" if waiting else ""
    rest += "".join(f"; left out: {error}" for error in new.left_out.values())
    message = f"tokens, rights, policies and places were reloaded{rest}"
    _log.info(RELOADED, message=message)
    done = replace(plan, **{name: getattr(new, name) for name in _RELOADED})
    return done, ChangeAppResponse(success=True, message=message)
