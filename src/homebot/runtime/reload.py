"""Reloading of the configuration: tokens, rights, policies and places change at once, other keys at the next start."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from anyio import to_thread

from homebot.bridges.rosbridge import Door
from homebot.config import Config
from homebot.control import Control
from homebot.control.settings import PolicySettings
from homebot.devices.client_rights import ALL_ROBOTS, read_scope
from homebot.discovery import Directory
from homebot.errors import UsageError
from homebot.runtime.grants import ACT
from homebot.runtime.plan import Plan
from homebot.support.logger import get_logger

if TYPE_CHECKING:
    from homebot.bridges.thing_directory.bridge import ThingDirectoryBridge

__all__ = ["RunningParts", "keys_for_restart", "reload_configuration"]

RELOADED = "runtime.reloaded"

_log = get_logger(node="/homebot")

_SECTIONS: Final = ("gateways", "apps", "robots")
"""The keys that contain tables by name."""

_LIVE: Final[Mapping[str, frozenset[str]]] = {
    "door": frozenset({"token", "token_file", "tokens", "scope"}),
    "control": frozenset(PolicySettings.model_fields),
    "apps": frozenset({ACT}),
    "thing_directory": frozenset({ACT}),
}
"""The keys that take effect without a restart; so do all of ``[places]``."""


class RunningParts(NamedTuple):
    """The running components to update.

    Attributes:
        door: Returns the door; None before it listens.
        control: None before it runs.
        directory: None before it runs.
        things: None before it runs.
    """

    door: Callable[[], Door | None]
    control: Control | None
    directory: Directory | None
    things: ThingDirectoryBridge | None


def keys_for_restart(before: Config, after: Config) -> tuple[str, ...]:
    """Return the keys that differ and take effect at the next start."""
    old, new = before.model_dump(exclude={"places"}), after.model_dump(exclude={"places"})
    keys = (key for table in old for key in _changed(table, old[table] or {}, new[table] or {}))
    robots = sorted(_robots(new["door"]) - _robots(old["door"]) - {ALL_ROBOTS, *old["robots"], *new["robots"]})
    return (*keys, *(f"door.tokens (the robot {name})" for name in robots))


def _robots(door: Mapping[str, Any]) -> set[str]:
    """Return the names of the robots that tokens may act as, which are tracked from the start."""
    return {name for one in door.get("tokens", {}).values() for name in read_scope(one.get("scope", ())).robots}


def _changed(table: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[str]:
    for key in dict.fromkeys((*old, *new)):
        if old.get(key) == new.get(key) or key in _LIVE.get(table, ()):
            continue
        if table in _SECTIONS and key in old and key in new:
            rest = (one for one in dict.fromkeys((*old[key], *new[key])) if one not in _LIVE.get(table, ()))
            yield from (f"{table}.{key}.{one}" for one in rest if old[key].get(one) != new[key].get(one))
        else:
            yield f"{table}.{key}"


async def reload_configuration(
    running: Config, plan: Plan, parts: RunningParts, read: Callable[[], Config], make_plan: Callable[[Config], Plan]
) -> Plan:
    """Apply the changes in the configuration from *read* that need no restart; if it has a mistake, change nothing.

    Args:
        read: Called in a worker thread.
        make_plan: Called in a worker thread, with the result of *read*.
    """
    try:
        config = await to_thread.run_sync(read)
        new = await to_thread.run_sync(make_plan, config)
        rooms = None if parts.directory is None else parts.directory.index.owner.rooms.reconfigured(new.places)
    except UsageError as exc:
        _log.error(RELOADED, message=f"nothing was reloaded: {exc}")
        return plan
    if (server := parts.door()) is not None:
        server.update_tokens(new.door)
    if parts.things is not None and new.thing_directory is not None:
        parts.things.update_token(new.thing_directory)
    plan.grants.clear()  # in place: other components refer to it
    plan.grants.update(new.grants)
    needs_approval = parts.control is None or parts.control.update_policies(new.control)
    if parts.directory is not None and rooms is not None:
        parts.directory.index.postings.needs_approval = needs_approval
        if new.places != plan.places:
            await parts.directory.reconfigure(new.places, rooms)
    waiting = ", ".join(keys_for_restart(running, config))
    rest = f"; restart homebot for the changes of {waiting}" if waiting else ""
    _log.info(RELOADED, message=f"tokens, rights, policies and places were reloaded{rest}")
    things = new.thing_directory or plan.thing_directory
    return replace(plan, door=new.door, control=new.control, places=new.places, thing_directory=things)
