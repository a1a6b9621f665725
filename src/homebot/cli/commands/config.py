"""``homebot config``, and the checks of ``homebot doctor --offline``: the requirements for a start."""

import argparse
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import anyio

from homebot.bridges.zenoh.logins import login_notes, logins_of
from homebot.cli.arguments import DEFAULT_CONFIG, add_verb, add_verbs, set_command
from homebot.cli.commands.run import config_errors, with_environment
from homebot.config import load_config, load_tables
from homebot.devices.findings import Finding, FindingKind, Row
from homebot.errors import ConfigError, HomebotError
from homebot.gateways import Gateway
from homebot.log import configure_logging
from homebot.plugins import INSTALL_EXTRA
from homebot.runtime.home_folder import index_place, unused_folders
from homebot.runtime.plan import Plan, PlannedComponent, make_plan
from homebot.runtime.saved_files import SAVED_FILES
from homebot.support.file_access import readable_by_others, why_not_trusted
from homebot.support.sqlite_file import why_not_readable

_EXAMPLES = """\
  homebot config check                            check homebot.toml
  homebot config check villa.toml                 check another file
"""

_REACH_WITHIN = 5.0
_SECRET_FILES = ("token_file", "password_file", "key_file")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    check = add_verb(verbs, "check", "check a configuration file: keys, values, plug-ins and credentials")
    check.add_argument("file", metavar="FILE", nargs="?", help="the file (default: homebot.toml)")
    check.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the same as FILE")
    set_command(check, _check, _EXAMPLES)


def _check(options: argparse.Namespace) -> int:
    configure_logging()
    path = Path(options.file or options.config)
    if errors := config_errors(load_tables(path), path):
        for error in errors:
            print(f"homebot: {error}", file=sys.stderr)
        return 1
    plan = plan_of(path)
    print(f"{path} is valid: home {plan.home}")
    print(f"  gateways:  {_list(map(_gateway_text, plan.gateways))}")
    print(f"  apps:      {_list(app.name for app in plan.apps)}")
    print(f"  rosbridge: {plan.door.host}:{plan.door.port}{' (token required)' if plan.door.token else ''}")
    if plan.link is not None and plan.link.listen:
        print(f"  ROS 2:     {plan.link.listen}; may log in: {_list(logins_of(plan.link, plan.door))}")
        for note in login_notes(plan.link, plan.door):
            print(f"             {note}")
    return 0


def plan_of(path: Path) -> Plan:
    """Return the plan of a run with the configuration *path*.

    Raises:
        ConfigError: The configuration is invalid.
    """
    return make_plan(with_environment(load_config(path)))


def _gateway_text(gateway: PlannedComponent[Gateway]) -> str:
    return f"{gateway.name} (observing only)" if gateway.kind.observes(gateway.settings) else gateway.name


def _list(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"


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
    missing = tuple(error for error in errors if INSTALL_EXTRA in error.reason)
    yield from _finding(FindingKind.CONFIGURATION, _of_errors(error for error in errors if error not in missing))
    yield from _finding(FindingKind.EXTRA, _of_errors(missing))
    yield from _finding(FindingKind.SECRET, _readable_secrets(tables, path.parent))
    if errors:
        return
    settings = with_environment(load_config(path))
    plan = make_plan(settings)
    yield from _finding(FindingKind.PORT, _taken_ports(plan))
    if plan.discovery.persist:
        folder = index_place(settings, path).parent
        yield from _finding(FindingKind.FOLDER, _folder_problem(folder))
        yield from _finding(FindingKind.FILE, _unreadable_files(folder))
        yield from _finding(FindingKind.NOTE, (("", text) for text in unused_folders(folder)), "homebot")
    if plan.link is not None:
        yield from _finding(FindingKind.NOTE, (("", text) for text in login_notes(plan.link, plan.door)), "homebot")
    if reaches:
        yield from _finding(FindingKind.NETWORK, anyio.run(_unreachable, plan))


def _finding(kind: FindingKind, rows: Iterable[Row], where: str = "") -> Iterator[Finding]:
    if all_rows := tuple(rows):
        yield kind.finding(all_rows, where)


def _of_errors(errors: Iterable[ConfigError]) -> Iterator[Row]:
    return (("", str(error)) for error in errors)


def _readable_secrets(tables: Mapping[str, object], folder: Path) -> Iterator[Row]:
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _readable_secrets(value, folder)
        elif key in _SECRET_FILES and isinstance(value, str):
            with suppress(OSError):
                if problem := readable_by_others(folder / value, (folder / value).stat()):
                    yield ("", problem)


def _taken_ports(plan: Plan) -> Iterator[Row]:
    if problem := plan.door.why_not_free("[door] port"):
        yield ("", f"door: {problem}")


def _folder_problem(folder: Path) -> Iterator[Row]:
    """Yield why files cannot be stored in *folder*, which is created at the first start."""
    there = next(parent for parent in (folder, *folder.parents) if parent.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        yield ("", f"{there} cannot be written by this user, but files have to be stored in {folder}")
    elif problem := why_not_trusted(there):
        yield ("", problem)


def _unreadable_files(folder: Path) -> Iterator[Row]:
    for name, schema in SAVED_FILES.items():
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
