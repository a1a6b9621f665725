"""The log of a run that is watched in the terminal."""

from __future__ import annotations

import io
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, TextIO, cast, final

from homebot.cli.terminal import is_terminal
from homebot.log import configure_logging

__all__ = ["quiet_log"]

_MOST: Final = 40


@final
class _LastLines(io.TextIOBase):
    """The newest lines of the log, which would tear the view."""

    def __init__(self) -> None:
        self.lines: deque[str] = deque(maxlen=_MOST)

    def write(self, text: str) -> int:
        """Keep *text*, and drop the oldest."""
        self.lines.append(text)
        return len(text)


@contextmanager
def quiet_log() -> Iterator[None]:
    """Keep the log from the terminal during the block; show its end after an error."""
    if not is_terminal(sys.stderr):
        configure_logging()
        yield
        return
    log = _LastLines()
    configure_logging(stream=cast("TextIO", log))
    try:
        yield
    except BaseException:
        sys.stderr.write("".join(log.lines))
        raise
