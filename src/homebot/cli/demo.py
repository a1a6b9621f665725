"""The beginning of a run that is watched in the terminal: everything that it needs before the house is loaded."""

from __future__ import annotations

import io
import os
import shutil
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final, TextIO, cast, final

from homebot.cli.arguments import DEFAULT_DOOR
from homebot.cli.terminal import is_terminal
from homebot.log import configure_logging

if TYPE_CHECKING:
    from homebot.house import World

__all__ = ["hint_of", "quiet_log", "title_of"]

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


def title_of(world: World, page: str) -> str:
    """Return the title of a view of *world*, with the address of the *page*."""
    return f"homebot · simulated, {world.time.pace:g}x speed · {page}"


def hint_of(world: World, page: str) -> str:
    """Return a command to try in a second terminal, as it works there."""
    lamp = next((name for name in world.devices if "lamp" in name and "kitchen" in name), next(iter(world.devices), ""))
    here = str(Path(sys.executable).with_name("homebot"))
    program = "homebot" if shutil.which("homebot") else min(os.path.relpath(here), here, key=len)
    address = page.rpartition("/")[2]
    door = "" if address == "{}:{}".format(*DEFAULT_DOOR) else f" --door {address}"
    return f"Try in a second terminal:  {program} why {lamp}{door}    (Ctrl-C ends)"


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
