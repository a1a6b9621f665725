"""Commands as a user gives them in a shell with the project's .venv, and a homebot that runs beside."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tests.ports import reserve_door

__all__ = ["Homebot", "environment", "homebot_in", "run"]


@dataclass
class Homebot:
    """A homebot that runs in a process of its own, with its log as far as it was read."""

    folder: Path
    door: str = field(default_factory=reserve_door)
    log: list[str] = field(default_factory=list)

    def run(self, command: str) -> subprocess.CompletedProcess[str]:
        return run(command, door=self.door, cwd=self.folder)


def environment(door: str) -> dict[str, str]:
    return {**os.environ, "HOMEBOT_DOOR": door, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}


def run(command: str, *, door: str = "", cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        shlex.split(command),
        cwd=cwd,
        env=environment(door or reserve_door()),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@contextmanager
def homebot_in(folder: Path, *arguments: str, until: tuple[str, ...], house: str = "") -> Iterator[Homebot]:
    """Run ``homebot run`` in *folder*, at least until lines with *until*; it must end well.

    Args:
        house: The text of a simulated house, which is written to the folder; empty for none.
    """
    if house:
        (folder / "house.toml").write_text(house)
        arguments = ("--house", "house.toml", "--ephemeral", *arguments)
    homebot, left = Homebot(folder), set(until)
    with subprocess.Popen(
        ["homebot", "run", *arguments], env=environment(homebot.door), stderr=subprocess.PIPE, text=True, cwd=folder
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            homebot.log.append(line)
            left -= {one for one in left if one in line}
            if not left:
                break
        assert not left, homebot.log
        try:
            yield homebot
        finally:
            process.send_signal(signal.SIGTERM)
            _, rest = process.communicate(timeout=120)
    assert process.returncode == 0
    assert "Traceback" not in rest
