"""The folder of a home's data: ``homes/ID``, of an id that stays when the home's name or a gateway's address changes.

The configuration has the id, and the folder the path of the configuration, which decides if that cannot be written.
Earlier versions named folders after the home and the network of its first gateway; such a folder is moved once.
"""

import re
import secrets
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from typing import Final, NamedTuple

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.config import UNNAMED, Config
from homebot.discovery.store import INDEX_FILE, index_path
from homebot.errors import ConfigError, InvalidNameError, LinkError, UsageError
from homebot.feature import plugin_tables
from homebot.names import unescape_token
from homebot.runtime.plan import make_plan
from homebot.support.data_folder import data_directory
from homebot.support.file_access import replace_file
from homebot.support.logger import get_logger
from homebot.support.toml_file import read_toml

MOVED = "home.moved"
OTHERS = "home.others"
UNSETTLED = "home.unsettled"

HOME_FILE: Final = "home.json"

_HOMES: Final = "homes"
_ID: Final = re.compile(r"[0-9a-f]{16}")
_TOKEN: Final = re.compile(r"\w+", re.ASCII)
_MAX_FOLDERS: Final = 1000
_MADE: Final = "  # made by homebot, which finds the data of this home by it"

_log = get_logger(node="/homebot")


class _HomeFacts(BaseModel):
    """Facts in a folder about its home, of the last start.

    Attributes:
        networks: Those of its gateways: a broker's host and port, else the gateway's name.
        config: The file of its configuration; empty for an earlier version's folder, or one whose home took another.
    """

    model_config = ConfigDict(frozen=True)

    name: str
    networks: tuple[str, ...] = ()
    config: str = ""

    def has_network_of(self, other: "_HomeFacts") -> bool:
        return not set(self.networks).isdisjoint(other.networks)

    def may_be(self, other: "_HomeFacts") -> bool:
        """Return whether both may be facts of one home, before and after a change."""
        return self.name.casefold() == other.name.casefold() or self.has_network_of(other)


class _HomeFolder(NamedTuple):
    path: Path
    facts: _HomeFacts

    def belongs_to_other(self, file: Path | None) -> bool:
        """Return whether another configuration than *file* uses it."""
        config = Path(self.facts.config)
        return bool(self.facts.config) and config != file and _id_in(config) in {"", self.path.name}


def index_place(config: Config, file: Path | None) -> Path:
    """Return the index file of *config*, from *file*, where it is now or will be after the next start.

    Raises:
        ConfigError: As :func:`make_plan`.
    """
    fits, _ = _find(config, _facts_of(config, file))
    return (fits or _new_folder(config)) / INDEX_FILE


def settle_home(config: Config, file: Path | None) -> Path:
    """Return the index file of a home that starts, after giving the home an id and moving an earlier version's folder.

    Args:
        file: The file of *config*, into which the id is written; None for none, whose data stay by name and network.

    Raises:
        ConfigError: As :func:`make_plan`, or the id is that of another home.
    """
    facts = _facts_of(config, file)
    folder, others = _find(config, facts)
    if file is None:
        return (folder or _new_folder(config)) / INDEX_FILE
    if folder is not None:
        _check_not_copied(config, _HomeFolder(folder, _facts_in(folder)), facts)
    if others:
        names = ", ".join(map(_show, others))
        _log.warning(OTHERS, message=f"the data in {names} were not taken; `homebot home adopt FOLDER` takes them")
    try:
        settled = _make_or_move(folder, folder if folder and _is_homes(folder) else _new_folder(config))
        _claim(settled, facts)
    except (OSError, LinkError) as exc:  # tried again at the next start
        place = folder or _new_folder(config)
        _log.warning(UNSETTLED, message=f"the data are in {place} for now: {exc}")
        return place / INDEX_FILE
    if config.home.id != settled.name and not _write_id(file, settled.name):
        _log.info(UNSETTLED, message=f"{file} cannot be changed; {settled / HOME_FILE} tells whose data these are")
    return settled / INDEX_FILE


def adopt_folder(config: Config, file: Path, wanted: str) -> Path:
    """Have the home of *config* take the data in the folder *wanted*; those that it had stay where they are.

    Raises:
        UsageError: There is no such folder, or it is another's or in use, or the id in *file* cannot be changed.
    """
    facts = _facts_of(config, file)
    paths = {(data_directory() / wanted).resolve(), Path(wanted).resolve()}
    folder = next((folder for folder in _folders() if folder.path in paths), None)
    if folder is None:
        known = ", ".join(_show(folder.path) for folder in _folders()) or "none"
        raise UsageError(f"{wanted} is no folder of a home; known are {known}")
    if folder.belongs_to_other(Path(facts.config)):
        raise UsageError(f"{wanted} belongs to the home of {folder.facts.config}; remove the id there first")
    from homebot.runtime.saved_files import check_unused  # noqa: PLC0415 - not at a start

    check_unused(index_place(config, file).parent)
    check_unused(folder.path)
    path = _make_or_move(
        folder.path, folder.path if _is_homes(folder.path) else _root() / _HOMES / secrets.token_hex(8)
    )
    if not _write_id(file, path.name) and config.home.id:
        raise UsageError(f'{file} cannot be changed; write id = "{path.name}" in [home] yourself')
    _claim(path, facts)
    return path


def claim_folder(path: Path, name: str, file: Path) -> None:
    """Record that the data in *path* belong to the home *name* of *file*, as after a restore."""
    _claim(path, _HomeFacts(name=name, config=str(file.resolve())))


def unused_folders(used: Path) -> Iterator[str]:
    """Yield a text about each known home whose data no configuration uses, besides *used*. Blocking."""
    for folder in _folders() if used.is_relative_to(_root()) else ():
        if folder.path != used and not folder.belongs_to_other(None):
            used_on = datetime.fromtimestamp((folder.path / INDEX_FILE).stat().st_mtime, UTC).date()
            name = _show(folder.path)
            text = f"data of the home {folder.facts.name}, last used on {used_on}, are not in use"
            yield f"{text}: homebot home adopt {name}"


def _find(config: Config, facts: _HomeFacts) -> tuple[Path | None, Sequence[Path]]:
    """Return the folder of the home, or None and those of which the owner has to choose."""
    if not facts.config:
        return index_path(facts.name, facts.networks[0]).parent, ()
    if config.home.id:
        return _root() / _HOMES / config.home.id, ()
    file = Path(facts.config)
    folders = [folder for folder in _folders() if not folder.belongs_to_other(file)]
    alike = [folder for folder in folders if folder.facts.may_be(facts)]
    first = index_path(facts.name, facts.networks[0]).parent.resolve()
    named = [folder for folder in alike if folder.facts.name.casefold() == facts.name.casefold()]
    for fitting in (
        [folder for folder in alike if folder.facts.config == facts.config],
        [folder for folder in alike if folder.path == first],
        [folder for folder in named if facts.name != UNNAMED or folder.facts.has_network_of(facts)],
    ):
        if fitting:
            return (fitting[0].path, ()) if len(fitting) == 1 else (None, [folder.path for folder in fitting])
    return None, [folder.path for folder in alike if folder.facts.has_network_of(facts)]


def _facts_of(config: Config, file: Path | None) -> _HomeFacts:
    plan = make_plan(config)
    gateways = [gateway for gateway in plan.gateways if gateway.name not in plugin_tables().values()]
    networks = [gateway.kind.network(gateway.settings) or gateway.name for gateway in gateways]
    return _HomeFacts(name=plan.home, networks=tuple(networks or ["none"]), config=str(file.resolve()) if file else "")


def _root() -> Path:
    return data_directory().resolve()


def _new_folder(config: Config) -> Path:
    return _root() / _HOMES / (config.home.id or secrets.token_hex(8))


def _is_homes(path: Path) -> bool:
    """Return whether *path* has the form of ``homes/ID``, rather than that of an earlier version's folder."""
    return path.parent == _root() / _HOMES and _ID.fullmatch(path.name) is not None


def _folders() -> list[_HomeFolder]:
    """Return the folders of all homes, also those of earlier versions."""
    paths = [index_file.parent for index_file in islice(_root().glob(f"*/*/{INDEX_FILE}"), _MAX_FOLDERS)]
    return [_HomeFolder(path, _facts_in(path)) for path in sorted(paths) if _TOKEN.fullmatch(path.name)]


def _facts_in(folder: Path) -> _HomeFacts:
    """Return the facts in *folder*; of its names in an earlier version's folder."""
    with suppress(OSError, ValidationError):
        return _HomeFacts.model_validate_json((folder / HOME_FILE).read_bytes())
    if _is_homes(folder):
        return _HomeFacts(name=folder.name)
    with suppress(InvalidNameError):
        return _HomeFacts(name=unescape_token(folder.parent.name), networks=(unescape_token(folder.name),))
    return _HomeFacts(name=folder.parent.name)


def _check_not_copied(config: Config, folder: _HomeFolder, facts: _HomeFacts) -> None:
    is_same = folder.facts.name == facts.name and folder.facts.has_network_of(facts)
    if folder.belongs_to_other(Path(facts.config)) and not is_same:
        problem = f"is the id of the home of {folder.facts.config}; without this line the home here gets one of its own"
        raise ConfigError(config.source, "home.id", problem)


def _make_or_move(old: Path | None, new: Path) -> Path:
    """Return the folder *new*, as it is, or empty, or with the data of another one *old*, of which a copy stays.

    Raises:
        LinkError: A running homebot has *old* open, or there is no room for the copy.
        OSError: The folder cannot be made, or *old* not be moved.
    """
    new.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    if old in {None, new}:
        new.mkdir(exist_ok=True, mode=0o700)
        return new
    from homebot.runtime.saved_files import copy_saved_files  # noqa: PLC0415 - once in the life of a home

    copy = copy_saved_files(old)
    kept = copy.rename(old.with_name(f"{old.name}.before-move-{time.time():.3f}"))
    old.rename(new)
    _log.info(MOVED, message=f"moved the data of the home from {old} to {new}; a copy is in {kept}")
    return new


def _claim(folder: Path, facts: _HomeFacts) -> None:
    """Note in *folder* whose data it has, and in others that they are not that home's."""
    for other in _folders():
        if other.path != folder and other.facts.config == facts.config:
            _write_facts(other.path, other.facts.model_copy(update={"config": ""}))
    if _facts_in(folder) != facts:
        _write_facts(folder, facts)


def _id_in(file: Path) -> str | None:
    """Return the id of the home of the configuration *file*, empty if it has none; None if there is no such file."""
    try:
        home = read_toml(file).get("home", {})
    except ConfigError:
        return "" if file.exists() else None  # half saved
    return str(home.get("id", "")) if isinstance(home, dict) else ""


def _write_id(file: Path, home: str) -> bool:
    """Write the id into *file*, in which nothing else changes; return whether that could be done."""
    from homebot.support.toml_edit import edit_toml  # noqa: PLC0415 - once in the life of a home

    try:
        text = file.read_bytes().decode()
        mark = "\ufeff" if text.startswith("\ufeff") else ""
        new = edit_toml(text.removeprefix(mark).replace("\r\n", "\n"), ("home",), {"id": home})
        if _MADE not in new:
            new = new.replace(f'id = "{home}"', f'id = "{home}"{_MADE}', 1)
        replace_file(file, (mark + (new.replace("\n", "\r\n") if "\r\n" in text else new)).encode())
    except (OSError, UsageError, ValueError):
        return False
    return True


def _write_facts(folder: Path, facts: _HomeFacts) -> None:
    replace_file(folder / HOME_FILE, facts.model_dump_json().encode())


def _show(path: Path) -> str:
    return path.relative_to(_root()).as_posix()
