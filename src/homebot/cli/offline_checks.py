"""Checks of ``homebot doctor --offline``: the requirements for a start."""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import anyio

from homebot.bridges.admission import AccessSettings
from homebot.cli.commands.run import config_errors, with_environment
from homebot.config import load_config, load_tables
from homebot.devices.findings import Finding, FindingKind, Row
from homebot.errors import ConfigError, HomebotError
from homebot.log import configure_logging
from homebot.plugins import INSTALL_EXTRA
from homebot.runtime.kept_files import KEPT_FILES
from homebot.runtime.plan import Plan, index_place, make_plan
from homebot.support.file_access import readable_by_others, why_not_trusted
from homebot.support.sqlite_file import why_not_readable

__all__ = ["offline_findings"]

_REACH_WITHIN = 5.0
_SECRET_FILES = ("token_file", "password_file")


def offline_findings(path: Path, *, reaches: bool) -> Iterator[Finding]:
    """Yield all problems that would prevent homebot from starting with the configuration *path*.

    Args:
        reaches: Whether to log in to the servers of gateways.
    """
    configure_logging()
    try:
        tables = load_tables(path)
        errors = config_errors(tables, path)
    except ConfigError as exc:
        yield from _finding(FindingKind.CONFIGURATION, _of_errors((exc,)))
        return
    missing = tuple(one for one in errors if INSTALL_EXTRA in one.reason)
    yield from _finding(FindingKind.CONFIGURATION, _of_errors(one for one in errors if one not in missing))
    yield from _finding(FindingKind.EXTRA, _of_errors(missing))
    yield from _finding(FindingKind.SECRET, _readable_secrets(tables, path.parent))
    if errors:
        return
    settings = with_environment(load_config(path))
    plan = make_plan(settings)
    yield from _finding(FindingKind.PORT, _taken_ports(plan))
    if plan.discovery.persist:
        folder = index_place(settings).parent
        yield from _finding(FindingKind.FOLDER, _folder_problem(folder))
        yield from _finding(FindingKind.FILE, _unreadable_files(folder))
    if reaches:
        yield from _finding(FindingKind.NETWORK, anyio.run(_unreachable, plan))


def _finding(kind: FindingKind, rows: Iterable[Row]) -> Iterator[Finding]:
    if found := tuple(rows):
        yield kind.finding(found)


def _of_errors(errors: Iterable[ConfigError]) -> Iterator[Row]:
    return (("", str(one)) for one in errors)


def _readable_secrets(tables: Mapping[str, object], folder: Path) -> Iterator[Row]:
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _readable_secrets(value, folder)
        elif key in _SECRET_FILES and isinstance(value, str):
            with suppress(OSError):
                if problem := readable_by_others(folder / value, (folder / value).stat()):
                    yield ("", problem)


def _taken_ports(plan: Plan) -> Iterator[Row]:
    servers: dict[str, AccessSettings | None] = {"door": plan.door, "thing_directory": plan.thing_directory}
    for name, settings in servers.items():
        if settings is not None and (problem := settings.why_not_free(f"[{name}] port")):
            yield ("", f"{name}: {problem}")


def _folder_problem(folder: Path) -> Iterator[Row]:
    """Yield why files cannot be stored in *folder*, which is created at the first start."""
    there = next(one for one in (folder, *folder.parents) if one.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        yield ("", f"{there} cannot be written by this user, but files have to be stored in {folder}")
    elif problem := why_not_trusted(there):
        yield ("", problem)


def _unreadable_files(folder: Path) -> Iterator[Row]:
    for name, schema in KEPT_FILES.items():
        path = folder / name
        try:
            problem = why_not_readable(path, schema) or why_not_trusted(path)
        except FileNotFoundError:
            continue
        except OSError as exc:
            problem = f"cannot be read: {exc.strerror}"
        if problem:
            yield (str(path), problem)


async def _unreachable(plan: Plan) -> list[Row]:
    rows: list[Row] = []
    for gateway in plan.gateways:
        problem = f"no answer within {_REACH_WITHIN:g} s: start it, or correct the address"
        with anyio.move_on_after(_REACH_WITHIN):
            try:
                await gateway.kind.reach(gateway.settings)
            except HomebotError as exc:
                problem = str(exc)
            else:
                continue
        network = gateway.kind.network(gateway.settings)
        rows.append((f"{gateway.name} ({network})" if network else gateway.name, problem))
    return rows
