"""A text that a person writes: from a file, from the standard input, or in an editor."""

import os
import shlex
import subprocess
import sys
from pathlib import Path
from tempfile import NamedTemporaryFile

from homebot.errors import UsageError


def read_text(file: str) -> str:
    """Return the text of *file*; ``-`` is the standard input.

    Raises:
        UsageError: It cannot be read.
    """
    try:
        return sys.stdin.read() if file == "-" else Path(file).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as exc:
        raise UsageError(f"{file} cannot be read: {getattr(exc, 'strerror', None) or exc}") from exc


def edited(text: str) -> tuple[str, Path]:
    """Return *text* as a person changed it in the editor, and the file in which it is.

    Raises:
        UsageError: There is no editor, it failed, or nothing was changed.
    """
    editor = os.environ.get("VISUAL") or os.environ.get("EDITOR")
    if not editor:
        raise UsageError("no editor is known; give a FILE, `-` for the standard input, or set EDITOR")
    with NamedTemporaryFile("w", encoding="utf-8", prefix="homebot-", suffix=".toml", delete=False) as file:
        file.write(text)
    path = Path(file.name)
    try:
        ended = subprocess.run([*shlex.split(editor), file.name], check=False).returncode  # noqa: S603 - as asked for
    except (OSError, ValueError) as exc:
        raise UsageError(f"the editor {editor!r} cannot be started: {exc}") from exc
    changed = read_text(file.name)
    if ended or changed == text:
        path.unlink()
        raise UsageError(f"the editor ended with {ended}; nothing is changed" if ended else "nothing is changed")
    return changed, path
