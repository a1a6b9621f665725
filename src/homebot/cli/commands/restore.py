"""``homebot restore``."""

import argparse
import filecmp
import os
import shutil
import sqlite3
import time
from pathlib import Path
from tempfile import mkdtemp

from homebot.cli.arguments import set_command
from homebot.cli.backup_archive import Manifest, extract_archive
from homebot.discovery.store import data_directory
from homebot.errors import UsageError
from homebot.runtime.kept_files import KEPT_FILES
from homebot.support.sqlite_file import why_not_readable

__all__ = ["add_arguments"]

_MODE = 0o755
"""The permissions of a restored file: not writable by others."""

_EXAMPLES = """\
  homebot restore villa.tar
  homebot restore villa.tar --into /etc/homebot

homebot must not be running. Existing files are moved aside, and named.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _restore, _EXAMPLES)
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
        _check_files(staged / "data")
        folder = root / manifest.folder
        _check_stopped(folder)
        aside = _move_in(staged, folder, options.into, manifest)
    finally:
        shutil.rmtree(staged, ignore_errors=True)
    print(f"restored {manifest.home}, as it was on {manifest.made}: {folder}, {options.into.absolute()}")
    for one in aside:
        print(f"moved aside: {one}")
    if missing := [name for name in manifest.left_out if not (options.into / name).exists()]:
        print(f"missing, because they contain secrets: {', '.join(missing)}; put them there before the start")
    return 0


def _check_files(data: Path) -> None:
    for path in sorted(data.glob("*.sqlite")):
        schema = KEPT_FILES.get(path.name)
        problem = "is not a file of homebot" if schema is None else why_not_readable(path, schema) or _damage(path)
        if problem:
            raise UsageError(f"{path.name} {problem}; nothing was restored")


def _damage(path: Path) -> str:
    connection = sqlite3.connect(path)
    try:
        (found,) = connection.execute("PRAGMA quick_check(1)").fetchone()
    except sqlite3.Error as exc:
        return f"is damaged: {exc}"
    finally:
        connection.close()
    return "" if found == "ok" else f"is damaged: {found}"


def _check_stopped(folder: Path) -> None:
    for path in (folder / name for name in KEPT_FILES):
        if not path.exists():
            continue
        connection = sqlite3.connect(path, timeout=0.1, isolation_level=None)
        try:
            connection.execute("BEGIN IMMEDIATE")
        except sqlite3.OperationalError as exc:
            if "locked" in str(exc):
                raise UsageError(f"{path} is in use by a running homebot; stop it first") from exc
        except sqlite3.DatabaseError:
            pass  # a damaged file is why a backup is restored
        finally:
            connection.close()


def _move_in(staged: Path, folder: Path, into: Path, manifest: Manifest) -> list[Path]:
    ending, aside = f".before-restore-{time.time():.3f}", []
    for one, file in manifest.files.items():
        if not one.startswith("config/"):
            continue
        new, old = staged / one, into / one.removeprefix("config/")
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
    if os.name == "posix" and os.geteuid() == 0:  # the service's user must be able to write them
        owner = data_directory().stat()
        for path in (folder.parent, folder, *folder.iterdir()):
            os.chown(path, owner.st_uid, owner.st_gid)
    return aside
