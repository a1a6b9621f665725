"""New files that only their owner reads, because they show when people were at home."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from homebot.errors import UsageError


def create_file(path: Path) -> IO[bytes]:
    """Create and open *path*.

    Raises:
        UsageError: It exists already, or cannot be written.
    """
    with explain_create_error(path):
        return open(path, "xb", opener=lambda name, flags: os.open(name, flags, 0o600))


@contextmanager
def explain_create_error(path: Path) -> Iterator[None]:
    """Raise the errors of creating *path* as :class:`UsageError`, with the next step."""
    try:
        yield
    except FileExistsError:
        raise UsageError(f"{path} exists already; delete it, or choose another name") from None
    except OSError as exc:
        raise UsageError(f"{path} cannot be written: {exc.strerror}") from exc
