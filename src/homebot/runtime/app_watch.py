"""Reloading of apps when their files change: ``homebot run --reload``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from anyio import to_thread
from anyio.abc import TaskStatus
from watchfiles import Change, awatch

from homebot.errors import HomebotError
from homebot.runtime.app_loading import source_of
from homebot.support.logger import get_logger

if TYPE_CHECKING:
    from homebot.runtime.app_manager import PlannedApp

WATCHED: Final = "app.watched"

_DEBOUNCE: Final = 200
"""Milliseconds to wait for further changes: an editor may write a file in several steps."""

_TURN: Final = 300
"""Milliseconds after which its thread checks whether it is cancelled."""

_log = get_logger(node="/homebot")


async def reload_changed_apps(
    apps: Iterable[PlannedApp], reload: Callable[[str], Awaitable[str]], *, task_status: TaskStatus[None]
) -> None:
    """Call *reload* with the name of an app in *apps* when its file, or a file of its package, changes."""
    sources = await to_thread.run_sync(_sources, apps)
    text = f"{', '.join(sources)}: reloaded on each change of the file" if sources else "no app has its own file"
    _log.info(WATCHED, message=text, apps=[*sources])
    task_status.started()
    if not sources:
        return
    # Folders are watched, because an editor may replace a file; not recursively: they may contain whole environments.
    folders = await to_thread.run_sync(_folders, sources.values())

    def is_source(change: Change, path: str) -> bool:
        return change is not Change.deleted and any(_has(source, Path(path)) for source in sources.values())

    watching = awatch(*folders, watch_filter=is_source, debounce=_DEBOUNCE, rust_timeout=_TURN, recursive=False)
    async for changes in watching:
        changed = {Path(path) for _, path in changes}
        for name, source in sources.items():
            if any(_has(source, path) for path in changed):
                with suppress(HomebotError):  # already logged
                    await reload(name)


def _has(source: Path, path: Path) -> bool:
    return path == source or (path.suffix == ".py" and source in path.parents)


def _sources(apps: Iterable[PlannedApp]) -> dict[str, Path]:
    sources = {app.name: source_of(app.kind) for app in apps}
    return {name: path for name, path in sources.items() if path is not None}


def _folders(sources: Iterable[Path]) -> set[Path]:
    folders: set[Path] = set()
    for source in sources:
        inner = (module.parent for module in source.rglob("*.py"))
        folders |= {source, *inner} if source.is_dir() else {source.parent}
    return folders
