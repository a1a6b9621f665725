"""The data files of a run, which are in one folder: their schemas, and copies of them."""

import shutil
import sqlite3
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from anyio import to_thread

from homebot.apps.stores import STORE_SCHEMA
from homebot.devices.names import COPY_FILES
from homebot.discovery.store import INDEX_FILE, INDEX_SCHEMA
from homebot.errors import LinkError, UsageError
from homebot.feature import all_features, load
from homebot.graph import Node
from homebot.journal.journal_file import JOURNAL_SCHEMA
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.runtime.app_host import STORE_FILE
from homebot.runtime.plan import JOURNAL_FILE
from homebot.support.installation import INSTALLATION_FILE
from homebot.support.sqlite_file import SqliteFile, SqliteSchema, copy_database, is_in_use

SAVED_FILES: Final[Mapping[str, SqliteSchema]] = {
    INDEX_FILE: INDEX_SCHEMA,
    JOURNAL_FILE: JOURNAL_SCHEMA,
    STORE_FILE: STORE_SCHEMA,
    **{name: load(schema) for feature in all_features() for name, schema in feature.files.items()},
}

_COPIES: Final = "copies-"
_LEFT_BEHIND: Final = 3600.0


def copy_saved_files(folder: Path) -> Path:
    """Copy the files in *folder* into a new folder in it, and return the latter, which the caller has to remove.

    Raises:
        LinkError: Another process has a file open, or a copy cannot be written.
    """
    opened = SqliteFile.opened_in(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        for old in folder.glob(f"{_COPIES}*"):
            if time.time() - old.stat().st_mtime > _LEFT_BEHIND:
                shutil.rmtree(old)
        copies = Path(mkdtemp(prefix=_COPIES, dir=folder))
    except OSError as exc:
        raise LinkError(f"no copies can be made in {folder}: {exc.strerror}") from exc
    try:
        for name in SAVED_FILES:
            if name in opened:
                opened[name].copy_into(copies / name)
            elif (folder / name).exists():
                copy_database(folder / name, copies / name)
        if (folder / INSTALLATION_FILE).exists():
            shutil.copyfile(folder / INSTALLATION_FILE, copies / INSTALLATION_FILE)
    except BaseException as exc:
        shutil.rmtree(copies, ignore_errors=True)
        if isinstance(exc, OSError):
            raise LinkError(f"{copies} cannot be written: {exc.strerror}") from exc
        raise
    return copies


def check_unused(folder: Path) -> None:
    """Check that no running homebot uses the files in *folder*.

    Raises:
        UsageError: One does.
    """
    for path in (folder / name for name in SAVED_FILES):
        if not path.exists():
            continue
        connection = sqlite3.connect(path, timeout=0.1, isolation_level=None)
        try:
            connection.execute("BEGIN IMMEDIATE")
        except sqlite3.Error as exc:  # any other is why a backup is restored
            if is_in_use(exc):
                raise UsageError(f"{path} is in use by a running homebot; stop it first") from exc
        finally:
            connection.close()


def serve_copies(node: Node, folder: Path | None) -> None:
    """Serve copying the files in *folder*; the message of the answer is the folder of the copies."""

    async def answer(_: TriggerRequest) -> SuccessResponse:
        if folder is None:
            return SuccessResponse(success=False, message="this homebot keeps nothing")
        for file in SqliteFile.used_in(folder):
            if file.write_rest is not None:
                await file.write_rest()
        try:
            return SuccessResponse(success=True, message=str(await to_thread.run_sync(copy_saved_files, folder)))
        except LinkError as exc:
            return SuccessResponse(success=False, message=str(exc))

    node.create_service(Trigger, COPY_FILES, answer)
