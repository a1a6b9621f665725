"""The identity of this homebot, which distinguishes it from others on the network and on this computer.

A file beside the index keeps it across restarts and moves to another computer. A file belongs to one running homebot; a
second one of the same home, or one without files, gets an identity for the run.
"""

import hashlib
import json
import os
import sys
from pathlib import Path
from random import Random, SystemRandom
from threading import Lock
from typing import Final

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

INSTALLATION_FILE: Final = "installation.json"
"""The name of the file, beside the index file."""

_MAX_CHARACTERS: Final = 4096
_MAX_NAMES: Final = 20
_DIGITS: Final = 16


class Installation:
    """The id of this homebot, and its names on the network. Blocking; called from worker threads.

    An unusable file, or one without an identity, is replaced by a new identity.

    Args:
        file: The file; None for none.
        random: The source of new ids, seeded for reproducible runs.

    Attributes:
        problem: Why the identity could not be saved, in words; empty if it was, or has not been needed yet.
    """

    def __init__(self, file: Path | None = None, random: Random | None = None) -> None:
        self._file = file
        self._random = random or SystemRandom()
        self._lock = Lock()
        self._descriptor: int | None = None
        self._id = ""
        self._names: dict[str, str] = {}
        self.problem = ""

    @property
    def folder(self) -> Path | None:
        """The folder of homebot's files; None if it has none."""
        return None if self._file is None else self._file.parent

    def id_of(self, part: str) -> str:
        """Return the id of a part of this homebot: 16 hexadecimal digits that reveal nothing about the computer."""
        with self._lock:
            self._load()
            return hashlib.sha256(f"homebot {self._id} {part}".encode()).hexdigest()[:_DIGITS]

    def renew(self) -> None:
        """Choose a new id, because another homebot has this one, for example after the file was copied."""
        with self._lock:
            self._load()
            self._id = self._new_id()
            self._save()

    def name_for(self, wanted: str) -> str:
        """Return the network name used the last time that *wanted* was taken, or else *wanted*."""
        with self._lock:
            self._load()
            return self._names.get(wanted, wanted)

    def store_name(self, wanted: str, got: str) -> None:
        """Store the name used in place of *wanted*, as RFC 6762, section 9, recommends."""
        with self._lock:
            self._load()
            if self._names.get(wanted, wanted) != got and len(self._names) < _MAX_NAMES:
                self._names[wanted] = got
                self._save()

    def close(self) -> None:
        """Release the file; the identity stays."""
        with self._lock:
            if self._descriptor is not None:
                os.close(self._descriptor)
                self._descriptor = self._file = None

    def _load(self) -> None:
        if self._id:
            return
        fields = self._read()
        installation_id, names = fields.get("id"), fields.get("names")
        self._id = installation_id if isinstance(installation_id, str) and len(installation_id) == _DIGITS else ""
        if isinstance(names, dict):
            self._names = {name: got for name, got in names.items() if isinstance(got, str)}
        if not self._id:
            self._id = self._new_id()
            self._save()

    def _read(self) -> dict[str, object]:
        if self._file is None:
            return {}
        try:
            self._descriptor = _open_alone(self._file)
            known = json.loads(os.read(self._descriptor, _MAX_CHARACTERS) or "{}")
        except (OSError, ValueError, RecursionError) as exc:
            self.problem = f"{self._file}: {exc}"
            return {}
        return known if isinstance(known, dict) else {}

    def _save(self) -> None:
        if self._descriptor is None:
            return
        text = json.dumps({"id": self._id, "names": self._names}).encode()
        try:
            os.lseek(self._descriptor, 0, os.SEEK_SET)
            os.truncate(self._descriptor, 0)
            os.write(self._descriptor, text)
        except OSError as exc:  # a full disk
            self.problem = f"{self._file}: {exc}"

    def _new_id(self) -> str:
        return f"{self._random.getrandbits(4 * _DIGITS):0{_DIGITS}x}"


def _open_alone(path: Path) -> int:
    """Open the file exclusively for this process.

    Raises:
        OSError: It cannot be opened, or another homebot has it.
    """
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        if sys.platform == "win32":
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor
