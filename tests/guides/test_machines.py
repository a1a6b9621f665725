"""The guide of several machines: its two machines, as it says, on this computer."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from tests.guide import blocks_in, commands_in, guide
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.shell import environment, homebot_in
from tests.system.attack_probe import until

GUIDE = guide("machines")
TABLES = blocks_in(GUIDE, "toml")
INVITE, RUN_FIRST, JOIN, RUN_SECOND = commands_in(GUIDE)

pytestmark = [pytest.mark.slow, pytest.mark.rooms("machine")]


def shell(command: str, folder: Path, typed: str = "") -> str:
    words = shlex.split(command)
    done = subprocess.run(
        words, cwd=folder, input=typed, env=environment(""), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_second_machine_joins_and_its_lamp_obeys_the_first(tmp_path: Path) -> None:
    first, second, port = tmp_path / "first", tmp_path / "second", str(reserve_port())
    for folder in (first, second):
        folder.mkdir()
    (first / "homebot.toml").write_text(TABLES[0].replace("7447", port))
    printed = shell(INVITE, first)
    assert f"homebot join tcp/127.0.0.1:{port}" in printed
    code = printed.split()[-1]
    assert "which only you can read" in shell(JOIN.replace("7447", port), second, f"{code}\n")
    with (second / "homebot.toml").open("a") as file:
        file.write(TABLES[1])
    with (
        homebot_in(first, *RUN_FIRST.split()[2:], "--ephemeral", until=("is running",)) as house,
        homebot_in(second, *RUN_SECOND.split()[2:], "--ephemeral", until=("is running",)),
    ):
        (command,) = re.findall(r"`(homebot do .*?)`", GUIDE)
        until(lambda: house.run("homebot show philips165").returncode == 0 or None, PATIENCE)
        done = house.run(command)
        assert "confirmed" in done.stdout, done.stderr
