"""A changed configuration while homebot runs: the tokens of clients take effect, other tables wait for a restart."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from anyio import to_thread

from homebot.bridges.rosbridge import Door
from homebot.config import Config
from homebot.errors import UsageError
from homebot.runtime.plan import make_plan
from homebot.support.logger import get_logger

__all__ = ["reload_tokens", "tables_for_restart"]

RELOADED = "runtime.reloaded"

_log = get_logger(node="/homebot")

_TOKENS = frozenset({"token", "token_file", "tokens", "scope"})
"""The keys of ``[door]`` that take effect without a restart."""


def tables_for_restart(before: Config, after: Config) -> tuple[str, ...]:
    """Return the tables that differ and take effect at the next start."""
    return tuple(_changed(before, after))


def _changed(before: Config, after: Config) -> Iterator[str]:
    for name in ("home", "discovery", "control", "history", "notify", "places", "ros", "thing_directory"):
        if getattr(before, name) != getattr(after, name):
            yield name
    if any(before.door.get(key) != after.door.get(key) for key in (before.door.keys() | after.door.keys()) - _TOKENS):
        yield "door"
    for section in ("gateways", "apps", "robots"):
        old, new = getattr(before, section), getattr(after, section)
        yield from (f"{section}.{name}" for name in sorted(old.keys() | new.keys()) if old.get(name) != new.get(name))


async def reload_tokens(running: Config, read: Callable[[], Config], door: Callable[[], Door | None]) -> None:
    """Apply the tokens of the configuration that *read* returns; one with a mistake is ignored.

    Args:
        running: The configuration that homebot runs with.
        read: Called in a worker thread.
        door: Returns the door; None before it listens.
    """
    try:
        config = await to_thread.run_sync(read)
        plan = await to_thread.run_sync(make_plan, config)
    except UsageError as exc:
        _log.error(RELOADED, message=f"nothing was reloaded: {exc}")
        return
    if (server := door()) is not None:
        server.update_tokens(plan.door)
    waiting = ", ".join(f"[{name}]" for name in tables_for_restart(running, config))
    rest = f"; restart homebot for the changes of {waiting}" if waiting else ""
    _log.info(RELOADED, message=f"the tokens and rights of clients were reloaded{rest}")
