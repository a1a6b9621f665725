"""Permissions of files: files that others can change are refused, secrets that others can read are reported.

This follows ssh. A group counts as the user's own if it has the user's name and no other member. Without such
permissions, as on Windows, nothing is refused.
"""

import os
import select
import stat
import sys
from contextlib import suppress
from functools import lru_cache
from io import BufferedReader
from pathlib import Path
from tempfile import mkstemp

from homebot.errors import UsageError

if sys.platform != "win32":
    import grp
    import pwd

READABLE = "config.secret_readable"

_MAX_SECRET = 65_536
_MAX_WAIT = 1.0  # in seconds, for a program to write a secret into a pipe
_GROUP_WRITES, _OTHERS_WRITE = stat.S_IWGRP, stat.S_IWOTH
_GROUP, _OTHERS = stat.S_IRWXG, stat.S_IRWXO


def why_not_trusted(path: Path) -> str:
    """Return a problem with the owner or mode of *path*, with its remedy; empty if it is safe.

    The path and its folder must belong to the user or root, and neither these nor any folder above may be writable by
    others, except for parents with the sticky bit, such as ``/tmp``.
    """
    if os.name != "posix":
        return ""
    real = path.resolve()
    for number, place in enumerate((real, *real.parents)):
        try:
            status = place.stat()
        except OSError as exc:
            return f"{place} cannot be checked: {exc.strerror}"
        if number <= 1 and status.st_uid not in {0, os.geteuid()}:
            owner = _user_name(status.st_uid)
            return f"{place} belongs to the user {owner}; run homebot as that user, or make the file your own"
        is_shared = number > 0 and bool(status.st_mode & stat.S_ISVTX)
        if not is_shared and _is_writable_by_others(status):
            return f"{place} can be written by others; remove that permission: chmod go-w '{place}'"
    return ""


def why_not_private(path: Path, found: os.stat_result) -> str:
    """Return a problem with the owner or mode of the secret *path* with status *found*; empty if it is safe.

    Pipes and other non-files are not checked.
    """
    if os.name != "posix" or not stat.S_ISREG(found.st_mode) or not _is_writable_by_others(found):
        return ""
    return f"{path} can be written by others; keep it to yourself: chmod 600 '{path}'"


def readable_by_others(path: Path, found: os.stat_result) -> str:
    """Return a warning that others can read the secret file *path*; empty if they cannot."""
    if os.name != "posix" or not stat.S_ISREG(found.st_mode):
        return ""
    is_seen = bool(found.st_mode & _OTHERS) or (bool(found.st_mode & _GROUP) and not _is_private_group(found))
    return f"{path} can be read by others; keep it to yourself: chmod 600 '{path}'" if is_seen else ""


def open_now(path: Path) -> BufferedReader:
    """Open *path* for reading; neither this nor reading waits for the other end of a pipe."""
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0)))


def replace_file(path: Path, content: bytes) -> None:
    """Replace the file *path*, or the one that it links to, whole or not at all; it keeps its mode and owner.

    A new file is for its owner alone. Where the user is not in its group, the new group may as others. Blocking.

    Raises:
        OSError: It cannot be written, or belongs to another user, and only root could leave it so.
    """
    path = path.resolve()
    descriptor, name = mkstemp(prefix=f".{path.name}.", dir=path.parent)
    new = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            old = path.stat()
            mode = stat.S_IMODE(old.st_mode)
            if os.name == "posix":
                os.chown(new, old.st_uid, -1)
                try:
                    os.chown(new, -1, old.st_gid)
                except PermissionError:
                    mode = mode & ~_GROUP | (mode & _OTHERS) << 3
            new.chmod(mode)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def read_secret(path: Path) -> str:
    """Return the first line of the file *path*, without its line ending.

    If others can read it too, a warning is logged.

    Raises:
        UsageError: The file cannot be read, others can write it, or its first line is empty; never shows the secret.
    """
    try:
        with open_now(path) as file:
            check_secret_file(path, os.fstat(file.fileno()))
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                select.select([file], [], [], _MAX_WAIT)
            secret = file.readline(_MAX_SECRET).decode().rstrip("\r\n")
    except (OSError, ValueError) as exc:
        raise UsageError(f"{path} cannot be read: {_unreadable(path, exc)}") from exc
    if not secret:
        raise UsageError(f"the first line of {path} is empty")
    return secret


def check_secret_file(path: Path, found: os.stat_result) -> None:
    """Refuse the file *path* with status *found* if others can write it; warn if others can read it.

    Each file is warned of once, even if it is read repeatedly.

    Raises:
        UsageError: Others can write it.
    """
    if problem := why_not_private(path, found):
        raise UsageError(problem)
    if warning := readable_by_others(path, found):
        _warn_of_readers(warning, str(path), (found.st_dev, found.st_ino, found.st_ctime_ns))


def _is_writable_by_others(found: os.stat_result) -> bool:
    if found.st_mode & _OTHERS_WRITE:
        return True
    return bool(found.st_mode & _GROUP_WRITES) and not _is_private_group(found)


def _is_private_group(found: os.stat_result) -> bool:
    if found.st_gid == 0:
        return True
    try:
        owner, group = pwd.getpwuid(found.st_uid), grp.getgrgid(found.st_gid)
    except KeyError:
        return False
    return owner.pw_gid == group.gr_gid and group.gr_name == owner.pw_name and set(group.gr_mem) <= {owner.pw_name}


def _user_name(uid: int) -> str:
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return str(uid)


@lru_cache(maxsize=64)
def _warn_of_readers(warning: str, file: str, _identity: tuple[int, int, int]) -> None:
    from homebot.support.logger import get_logger  # noqa: PLC0415 - tools read a token without it

    get_logger().warning(READABLE, message=warning, file=file)


def _unreadable(path: Path, error: OSError | ValueError) -> str:
    if isinstance(error, PermissionError) and os.name == "posix":
        user = _user_name(os.geteuid())
        with suppress(PermissionError):
            path.stat()
            return f"it must belong to the user {user}: chown {user} '{path}'"
        return f"a folder on the way is closed to the user {user}; move the file to another one"
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error)
