"""``homebot backup`` and ``homebot restore``."""

import argparse
import filecmp
import os
import shutil
import sqlite3
import time
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from homebot.cli.arguments import DEFAULT_CONFIG, set_client_command, set_command
from homebot.cli.backup_archive import ArchivedFile, Manifest, extract_archive, write_archive
from homebot.cli.commands.run import with_environment
from homebot.cli.door_client import DoorClient, with_client
from homebot.config import load_config, load_tables, parse_config
from homebot.devices.names import COPY_FILES
from homebot.errors import LinkError, RefusedError, UsageError
from homebot.log import configure_logging
from homebot.runtime.declared_secrets import secrets_of, texts_of
from homebot.runtime.home_folder import claim_folder, index_place
from homebot.runtime.saved_files import SAVED_FILES, check_unused, copy_saved_files
from homebot.support.data_folder import data_directory
from homebot.support.sqlite_file import why_not_readable
from homebot.version import __version__

_EXAMPLES = """\
  homebot backup villa.tar
  homebot backup villa.tar --with-tokens      with all secrets; store it as safely as those
  homebot restore villa.tar

It contains all data of homebot (devices, journal, history, values of apps), homebot.toml and the files that this names
in its folder. homebot may be running, and writes its pending data first.
"""

_MAX_WAIT_S: Final = 120.0
_PRIVATE_KEY: Final = b" PRIVATE KEY-----"
"""In a file with a certificate and its key."""

_BLOCK: Final = 1_048_576

_MODE = 0o755
"""The permissions of a restored file: not writable by others."""

_RESTORE_EXAMPLES = """\
  homebot restore villa.tar
  homebot restore villa.tar --into /etc/homebot

homebot must not be running. Existing files are moved aside, and named.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _back_up, _EXAMPLES)
    parser.add_argument("file", metavar="FILE", help="the file to write, a tar")
    parser.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")
    parser.add_argument("--with-tokens", action="store_true", help="with passwords, tokens and other secrets")


def _back_up(options: argparse.Namespace) -> int:
    configure_logging()
    path = Path(options.config)
    folder = index_place(with_environment(load_config(path)), path).parent
    manifest = write_backup(path, _copies(folder, options), Path(options.file), with_secrets=options.with_tokens)
    print(f"{options.file}: {', '.join(name.partition('/')[2] for name in manifest.files)}")
    if secrets := manifest.left_out:
        print(f"left out, because they contain secrets: {', '.join(secrets)}; --with-tokens includes them")
    return 0


def write_backup(path: Path, copies: Path, target: Path, *, with_secrets: bool = False) -> Manifest:
    """Write the configuration *path*, and the *copies* of the data, which are removed, to the archive *target*.

    Raises:
        UsageError: The configuration is wrong, or *target* cannot be written.
    """
    folder = copies.parent
    try:
        tables = load_tables(path)
        config = parse_config(tables, str(path), path.parent)
        secret = secrets_of(config, tables)
        named = {name: key in secret.files or _has_key(path.parent / name) for key, name in _named_files(path, tables)}
        every = {path.name: bool(secret.texts), **named}
        files = {f"config/{name}": path.parent / name for name in every if with_secrets or not every[name]}
        data = {f"data/{copied.name}": copied for copied in sorted(copies.iterdir())}
        archived = {name: ArchivedFile(size=0, sha256="0" * 64, version=_version(name)) for name in (*data, *files)}
        manifest = Manifest(
            version=__version__,
            made=datetime.now(UTC).isoformat(timespec="seconds"),
            home=config.home.name,
            folder=f"{folder.parent.name}/{folder.name}",
            files=archived,
            left_out=() if with_secrets else tuple(name for name, is_secret in every.items() if is_secret),
        )
        write_archive(target, manifest, {**data, **files})
    finally:
        shutil.rmtree(copies, ignore_errors=True)
    return manifest


def _copies(folder: Path, options: argparse.Namespace) -> Path:
    """Return the folder of the copies, made by the running homebot or, without one, by this process."""
    try:
        return copy_saved_files(folder)
    except LinkError as exc:
        if "in use" not in str(exc):
            raise

    def ask(door: DoorClient, _: argparse.Namespace) -> int:
        answers.append(door.call(COPY_FILES, timeout=_MAX_WAIT_S))
        return 0

    answers: list[Mapping[str, object]] = []
    with_client(options, ask)
    if not answers[0]["success"]:
        raise RefusedError("a backup", str(answers[0]["message"]))
    return copies_in(folder, str(answers[0]["message"]))


def copies_in(folder: Path, answer: str) -> Path:
    """Return the folder of copies that a homebot named, which the caller removes.

    Raises:
        LinkError: It is not in *folder*.
    """
    copies = Path(answer).resolve()
    if copies.parent != folder.resolve():
        raise LinkError(f"that homebot keeps its files in {copies.parent}, not in {folder}; run this where it runs")
    return copies


def _version(name: str) -> int | None:
    schema = SAVED_FILES.get(name.removeprefix("data/"))
    return None if schema is None else schema.version


def _named_files(config: Path, tables: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    """Yield each value in *tables* that names a file beside *config*, such as an app, and the file's name there."""
    folder = config.parent.resolve()
    for _, value in texts_of(tables):
        name = value.partition(".py:")[0] + ".py" if ".py:" in value else value
        if name and len(name) < 200 and "\0" not in name and (folder / name).is_file():
            path = (folder / name).resolve()
            if path.is_relative_to(folder):
                yield value, path.relative_to(folder).as_posix()


def _has_key(path: Path) -> bool:
    with path.open("rb") as file:
        return _PRIVATE_KEY in file.read(_BLOCK)


def add_restore_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _restore, _RESTORE_EXAMPLES)
    parser.add_argument("file", metavar="FILE", help="a file from `homebot backup`")
    parser.add_argument(
        "--into",
        metavar="FOLDER",
        type=Path,
        default=Path(),
        help="target folder of homebot.toml (default: here)",
    )


def _restore(options: argparse.Namespace) -> int:
    """Check the whole archive, then move the old files aside and the new ones in."""
    root = data_directory()
    root.mkdir(parents=True, exist_ok=True, mode=0o700)
    staged = Path(mkdtemp(prefix="restore-", dir=root))
    try:
        manifest = extract_archive(Path(options.file), staged)
        for path in sorted((staged / "data").glob("*.sqlite")):
            schema = SAVED_FILES.get(path.name)
            problem = "is not a file of homebot" if schema is None else why_not_readable(path, schema) or _damage(path)
            if problem:
                raise UsageError(f"{path.name} {problem}; nothing was restored")
        folder = root / manifest.folder
        check_unused(folder)
        aside = _move_in(staged, folder, options.into, manifest)
    finally:
        shutil.rmtree(staged, ignore_errors=True)
    print(f"restored {manifest.home}, as it was on {manifest.made}: {folder}, {options.into.absolute()}")
    for moved in aside:
        print(f"moved aside: {moved}")
    if missing := [name for name in manifest.left_out if not (options.into / name).exists()]:
        print(f"missing, because they contain secrets: {', '.join(missing)}; put them there before the start")
    return 0


def _damage(path: Path) -> str:
    connection = sqlite3.connect(path)
    try:
        (verdict,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
    except sqlite3.Error as exc:
        return f"is damaged: {exc}"
    finally:
        connection.close()
    return "" if verdict == "ok" else f"is damaged: {verdict}"


def _move_in(staged: Path, folder: Path, into: Path, manifest: Manifest) -> list[Path]:
    ending, aside = f".before-restore-{time.time():.3f}", []
    for name, file in manifest.files.items():
        if not name.startswith("config/"):
            continue
        new, old = staged / name, into / name.removeprefix("config/")
        if old.exists() and not filecmp.cmp(new, old, shallow=False):
            aside.append(old.rename(old.with_name(old.name + ending)))
        if not old.exists():
            old.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(new, old)
            old.chmod(file.mode & _MODE)
    if folder.exists():
        aside.append(folder.rename(folder.with_name(folder.name + ending)))
    (staged / "data").mkdir(exist_ok=True)
    folder.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    (staged / "data").rename(folder)
    names = [name.removeprefix("config/") for name in manifest.files if name.startswith("config/")]
    claim_folder(folder, manifest.home, into / next((name for name in names if name.endswith(".toml")), DEFAULT_CONFIG))
    if os.name == "posix" and os.geteuid() == 0:  # the service's user must be able to write them
        owner = data_directory().stat()
        for path in (folder.parent, folder, *folder.iterdir()):
            os.chown(path, owner.st_uid, owner.st_gid)
    return aside
