"""Commands as a user gives them in a shell with the project's .venv, and a homebot that runs beside."""

import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path

import pytest
from tests.ports import reserve_door

from homebot.cli.door_client import open_door
from homebot.cli.main import main
from homebot.cli.server_address import ServerAddress


@dataclass
class Homebot:
    """A homebot that runs in a process of its own, with its log as far as it was read."""

    folder: Path
    door: str = field(default_factory=reserve_door)
    log: list[str] = field(default_factory=list)

    def run(self, command: str) -> subprocess.CompletedProcess[str]:
        return run(command, door=self.door, cwd=self.folder)

    def begin(self, command: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            shlex.split(command),
            cwd=self.folder,
            env=environment(self.door),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )


def environment(door: str) -> dict[str, str]:
    return {**os.environ, "HOMEBOT_DOOR": door, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}


def run(command: str, *, door: str = "", cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run *command* as a program; a client of homebot in this process, as a start takes a third of a second."""
    program, *words = shlex.split(command)
    door = door or reserve_door()
    if program != "homebot" or words[0] == "run":
        return subprocess.run(
            [program, *words],
            cwd=cwd,
            env=environment(door),
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    out, err = StringIO(), StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setenv("HOMEBOT_DOOR", door)
        patch.setattr(sys, "path", [*sys.path])
        patch.chdir(cwd or Path.cwd())
        code = main(words)
    return subprocess.CompletedProcess([program, *words], code, out.getvalue(), err.getvalue())


def publish(door: str, topic: str, ros_type: str, message: Mapping[str, object], times: int = 1) -> None:
    """Publish *message* at *door*, ten times a second."""
    host, _, port = door.rpartition(":")
    with open_door(ServerAddress(host, int(port))) as client:
        client.advertise(topic, ros_type)
        for number in range(times):
            if number:
                assert list(client.until(0.1)) == []  # nothing is subscribed to
            client.publish(topic, message)
            client.settle()


def publish_raw(door: str, address: str, payload: str, times: int = 1) -> None:
    """Let the gateway for MQTT at *door* publish *payload* on *address*."""
    publish(door, "/gateway/mqtt/out", "homebot/msg/RawCommand", {"address": address, "payload": payload}, times)


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
    assert "Traceback" not in rest, rest


def installed_package(there: Path, new: str, enter: str, *then: str) -> Path:
    """Write a package by the commands of a guide in *there*, and install it beside it without a network; its folder."""
    written = run(new, cwd=there)
    assert (written.returncode, written.stderr) == (0, "")
    assert f"try it: {' && '.join((enter, *then))}" in written.stdout
    folder = there / enter.removeprefix("cd ")
    offline = ("--no-deps", "--no-index", "--no-build-isolation", "--disable-pip-version-check", "--quiet")
    pip = [sys.executable, "-m", "pip", "install", *offline, "--target", str(there / "installed"), str(folder)]
    subprocess.run(pip, check=True, timeout=120)
    return folder
